"""What each stage of a sweep computes, one module per stage.

Every module has ``compute(spec, inputs) -> Output``: settings and stored inputs in, one record out. A stage
imports only what decides its result, since its results are keyed by that code (`datasets_gen.fingerprints`).
"""
