#pragma once

// The one way to include tinygltf: these switches change its classes, so every translation unit
// must see the same. Without a file system and an image decoder of its own it can neither open a
// file nor decode an image, whatever the asset says.

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
