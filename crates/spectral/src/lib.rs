//! Affinity W to Laplacian, eigenvalues, their zeros and the embedding U.
