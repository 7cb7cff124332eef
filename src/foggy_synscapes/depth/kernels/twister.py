"""The three first elements of random permutations, from the stream of MT19937 (Matsumoto and Nishimura, 1998).

A permutation of P is the order of P draws of 53 bits, so its first three are where the three smallest draws are. A draw
takes two words of the stream, of which the first decides unless it is equal: only this one is tempered for every draw.
"""

import numpy as np

from foggy_synscapes.jit import jit

U = np.uint32
WORDS, SHIFT = 624, 397
DRAWS = WORDS // 2
UPPER, LOWER, MATRIX = U(0x80000000), U(0x7FFFFFFF), U(0x9908B0DF)


@jit
def seeded(seed):
    """State of the generator after `init_genrand(seed)`; see `next_block` for what it holds."""
    state = np.empty(WORDS, np.uint32)
    state[0] = seed
    for i in range(1, WORDS):
        before = np.uint64(state[i - 1] ^ (state[i - 1] >> U(30)))
        state[i] = U((np.uint64(1812433253) * before + np.uint64(i)) & np.uint64(0xFFFFFFFF))
    return state


@jit
def next_block(state, other):
    """Write the next 624 words of the stream, before tempering, to `other`."""
    first, second = WORDS - SHIFT, 2 * (WORDS - SHIFT)  # what a word is made of lies so many words before it
    _mix(state[:first], state[1 : first + 1], state[SHIFT:], other[:first])
    _mix(state[first:second], state[first + 1 : second + 1], other[:first], other[first:second])
    _mix(state[second:-1], state[second + 1 :], other[first : SHIFT - 1], other[second:-1])
    _mix(state[-1:], other[:1], other[SHIFT - 1 : SHIFT], other[-1:])


@jit
def _mix(words, following, shifted, out):
    for i in range(out.size):
        word = (words[i] & UPPER) | (following[i] & LOWER)
        out[i] = shifted[i] ^ (word >> U(1)) ^ (U(0) - (word & U(1)) & MATRIX)


@jit
def _tempered(word):
    word ^= word >> U(11)
    word ^= (word << U(7)) & U(0x9D2C5680)
    word ^= (word << U(15)) & U(0xEFC60000)
    return word ^ (word >> U(18))


@jit
def temper_high(state, high):
    """The high 27 bits of each draw of a block: uint32 (312,)."""
    for i in range(high.size):
        high[i] = _tempered(state[2 * i]) >> U(5)


@jit
def draw(state, high, i):
    """Draw i of a block as a whole number of 53 bits."""
    return (np.int64(high[i]) << np.int64(26)) | np.int64(_tempered(state[2 * i + 1]) >> U(6))


@jit
def sample(states, high, at, count, found):
    """Where the three smallest of the next `count` draws are, to `found`, smallest first; returns the place after them.

    states : uint32 (2, 624), the block in use and memory for the next; high : of the block in use
    at : draws of the block that are used up
    """
    a = b = c = np.int64(1) << np.int64(53)  # the three smallest draws, and what of the third one the first word holds
    limit = U(1 << 27)
    begin = 0
    while begin < count:
        if at == DRAWS:
            next_block(states[0], states[1])
            states[0, :] = states[1]
            temper_high(states[0], high)
            at = 0
        some = min(count - begin, DRAWS - at)
        part = high[at : at + some]
        for group in range(0, some, 32):
            last = min(group + 32, some)
            near = False
            for i in range(group, last):
                near |= part[i] <= limit
            if not near:
                continue
            for i in range(group, last):
                if part[i] > limit:
                    continue
                value = draw(states[0], high, at + i)
                if value < c:  # of equal draws the first comes first
                    if value < b:
                        c, found[2] = b, found[1]
                        if value < a:
                            b, found[1] = a, found[0]
                            a, found[0] = value, begin + i
                        else:
                            b, found[1] = value, begin + i
                    else:
                        c, found[2] = value, begin + i
                    limit = U(c >> np.int64(26))
        at += some
        begin += some
    return at
