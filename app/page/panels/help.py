"""The Help panel: what one can do here, in a few lines."""

from __future__ import annotations

import viser

TEXT = """
**Drag the yellow puck** on a board: the parametric bias (PB) moves, and Pepper with it. On the
**PB map** (the upper board) it moves along two principal components, with **Shift** along the next
two. On the **landscape** (the lower one) it moves along two components of μ.

**Click a point** of the map to go to a learned motion.

The landscape shows how alike a motion stays to its target while μ changes: blue where it is the
same, red where it is the opposite. A smooth latent space has wide blue plains, a rugged one has
cliffs.

**Recognise**: give it a motion, as CSV (a header of joint names, one row a frame), as JSON or
NAOqi script as the tab **Robot** exports them, or as ROS, Choregraphe and others write them. The
model moves μ and σ until it reproduces what it sees, and says how much of it that explains. Beside
Pepper stands a robot that does what was given; **Reveal the rest** shows what it does after the
observed part. The violet cloud on the map is what the model believes by the frame that is played.

Keys: **Space** plays and pauses, **Z** undoes, **Y** does it again, **R** resets the view.
**Ctrl+K** opens the list of commands.

Model: J. Hwang and A. Ahmadi, *A Novel Framework for Learning Stochastic Representations for
Sequence Generation and Recognition*. Learnt from REBL-Pepper, M. Marmpena et al., CC BY 4.0.
"""


def add_help(gui: viser.GuiApi) -> None:
    gui.add_markdown(TEXT)
