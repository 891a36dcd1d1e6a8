#include "engine/cli/shard_option.h"

#include "engine/cli/number_option.h"

namespace palpate {

Result<Shard> parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto count = parse_integer(
      "--shard", slash == std::string::npos ? "" : text.substr(slash + 1), {1, kMostShards});
  const auto number = parse_integer("--shard", text.substr(0, slash), {1, count ? *count : 1});
  if (count && number) return Shard{static_cast<int>(*number), static_cast<int>(*count)};
  return invalid_argument(
      "--shard",
      "is \"" + text + "\"; expected i/n with 1 <= i <= n <= " + std::to_string(kMostShards),
      "write for example --shard 1/4");
}

}  // namespace palpate
