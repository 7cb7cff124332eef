"""No file makes a reader hang, break or stay silent: a short form of `make fuzz`."""

from fuzz import READERS, fuzz

INPUTS = 14  # for each reader; nine of them are FIFOs, devices and the like


def test_what_is_no_good_file_is_refused_by_name_or_does_no_harm() -> None:
    counts = fuzz(INPUTS, seed=1, names=[reader.name for reader in READERS])
    assert counts.total().total() >= 300
    assert counts.bad() == 0, f"{counts}\n" + "\n".join(counts.examples)
