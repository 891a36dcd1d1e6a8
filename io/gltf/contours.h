#pragma once

// extras.palpate_contour of a node (models/MODELS.md): the start and the end of a turn around the
// contour of an object.

#include <string>

#include "io/contour_description.h"
#include "io/gltf/accessor.h"
#include "io/gltf/nodes.h"

namespace palpate {

// The contour of a node that has this member; its points are transformed by the node's transform
// and those of its ancestors, in double. The instances of a node do not repeat the contour. If the
// member has another form, the result states this in ContourDescription::problem. name: the name of
// the node. Thread-safe.
ContourDescription read_contour(const GltfAsset& asset, const PlacedNode& placed,
                                const std::string& name);

}  // namespace palpate
