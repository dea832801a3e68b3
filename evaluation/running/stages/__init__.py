"""What each stage computes, one module per stage: everything here decides results.

Every module has ``compute(spec, inputs) -> Output``: settings and stored inputs in, one record out. A stage
imports only what decides its result, since its results are keyed by that code (`datasets_gen.fingerprints`).
"""
