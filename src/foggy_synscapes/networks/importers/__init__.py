"""Public weights of other code: which tensor is which, and what the network that holds them looks like."""
