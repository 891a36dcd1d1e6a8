#include "engine/cli/open_device.h"

#include <utility>

namespace palpate {

OpenDevice::~OpenDevice() {
  device_.command({});
  device_.stop();
}

std::optional<Error> OpenDevice::start() {
  auto problem = device_.start();
  if (!problem) return std::nullopt;
  return Error{ErrorCode::kFileUnreadable, "", "", std::move(*problem), ""};
}

}  // namespace palpate
