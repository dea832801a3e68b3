"""Dr.Jit forms of the heavy loops, for CUDA and LLVM."""
