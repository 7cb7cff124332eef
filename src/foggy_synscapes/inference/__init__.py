"""From images to classes, in several ways: a network in PyTorch, the same as an ONNX graph, and that in 8 bits."""
