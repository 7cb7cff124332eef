"""What each fog model is wrong by, in grey levels, against path tracing; and for which scene which one is enough."""
