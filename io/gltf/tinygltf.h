#pragma once

// Includes tinygltf. Every translation unit must include it through this header, because the macros
// below change its classes. The macros remove tinygltf's file access and image decoding, so that no
// asset can make tinygltf open a file or decode an image.

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
