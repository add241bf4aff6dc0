// Scores of search results: pages of the guide come before the reference and the laboratory.
const isGuide = (page) => /^docs\/(programs\/)?\w+$/.test(page);
var Scorer = {
  score: ([page, title, anchor, description, score]) => score + (isGuide(page) ? 40 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
