"""Light cards: planar lights with a position, a shape and a texture.

- `geometry`: the 3x3 matrix of a card
- `arrays`: checks of the arrays of cards
- `card`: a single card
- `cards`: the cards of a map
- `card_split`: the cards and the map without them, and their files
- `cut`: cards of the lights that `split` removed
"""

from envlights.cards.card import Card
from envlights.cards.card_split import CardSplit
from envlights.cards.cards import Cards

__all__ = ["Card", "CardSplit", "Cards"]
