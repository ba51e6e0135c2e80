"""Python side of matpoint: reading and drawing what a run has written.

    from matpoint import Results
    results = Results("results/disks")
    results.history["kinetic_energy"]                 # one value per row of history.csv
    results.bodies["lower"].field("velocity", 3)      # the particles at the 4th written time
"""

__all__ = ["Results", "ResultsError"]


def __getattr__(name: str):
    # Imported on first use: `python -m matpoint.plot` passes through here and must be able to say that NumPy is missing.
    if name in __all__:
        import matpoint.results

        return getattr(matpoint.results, name)
    raise AttributeError(f"module 'matpoint' has no attribute '{name}'")
