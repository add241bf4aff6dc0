"""Light cards: planar lights with a place, a shape and a texture.

- `geometry`: the 3x3 matrix of a card
- `arrays`: checks of the arrays of cards
- `card`: a single card
- `cards`: the cards of a map
- `cut`: cards of the lights that `split` removed
"""

from envlights.cards.card import Card
from envlights.cards.cards import Cards

__all__ = ["Card", "Cards"]
