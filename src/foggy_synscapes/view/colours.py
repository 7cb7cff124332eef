"""Colours of the 19 classes that people with any of the three kinds of dichromacy tell apart."""

import numpy as np

SAFE = np.array(
    [
        (117, 30, 124), (195, 161, 181), (57, 56, 58), (172, 181, 139), (161, 117, 56), (254, 255, 250), (228, 151, 44),
        (255, 234, 3), (76, 98, 76), (204, 252, 182), (6, 170, 238), (219, 38, 117), (152, 48, 0), (5, 0, 235),
        (43, 0, 60), (2, 139, 128), (78, 96, 255), (29, 239, 255), (71, 25, 0),
    ],
    dtype=np.uint8,
)  # fmt: skip
"""8-bit RGB of each class, in trainId order, shape (19, 3): near the colours of Cityscapes where that is possible.

Found by simulated annealing on the smallest CIEDE2000 between any two of them and black (unlabelled), in normal sight
and in simulated protanopia, deuteranopia and tritanopia: 14.4; that of the Cityscapes colours is 2.6 (vegetation and
person in deuteranopia). A test computes both. Sources: Sharma, Wu and Dalal, The CIEDE2000 Color-Difference Formula,
2005; Machado, Oliveira and Fernandes, A Physiologically-based Model for Simulation of Color Vision Deficiency, 2009.
"""

RIGHT, WRONG = (0, 114, 178), (213, 94, 0)
"""8-bit RGB of gain and loss: blue and vermilion. Source: Okabe and Ito, Color Universal Design, 2008."""
