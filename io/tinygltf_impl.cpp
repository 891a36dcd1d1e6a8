// The implementation of tinygltf, compiled once with our switches. Do not link libtinygltf.so as
// well: it was compiled with others.

#include <fstream>  // its writer needs it, and without TINYGLTF_NO_FS it would include it itself

#define TINYGLTF_IMPLEMENTATION
#include "io/tinygltf.h"
