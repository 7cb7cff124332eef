"""The stand-in's street renderer: arrays out, decided by a seed alone; and what stands in for each dataset."""
