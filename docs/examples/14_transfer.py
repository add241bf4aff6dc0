"""
Indirect light from direct light
================================

A linear model learns the indirect light of a room from pairs of images, and predicts it for a light
that it has not seen.
"""

import envlights as el

room = el.synthetic.room(64, width=64)
model = el.TransferModel.fit(room.direct[:-1], room.indirect[:-1])
print(model)
figure = el.plot.transfer_picture(model, room.direct[-1], room.indirect[-1])
