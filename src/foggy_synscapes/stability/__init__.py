"""What the numbers of this project do at the extremes, each against an answer that is known beforehand."""
