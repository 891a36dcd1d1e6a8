// The messages of the pages of `experiment live`: what is not as it must be is refused by name.

#include "engine/live/live_request.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

const std::vector<std::string> kOfParticipant = {
    R"({"type":"next","id":1,"step":"break"})",
    R"({"type":"consent","id":1,"value":true})",
    R"({"type":"about","id":1,"answers":{"age":"30"}})",
    R"({"type":"checked","id":1,"input":"mouse","motion":"unknown","css_px_per_mm":3.8,)"
    R"("device_pixel_ratio":1,"width_px":1920,"height_px":1080,"refresh_Hz":60,)"
    R"("unadjusted":true,"stroke_ratio":1.02})",
    R"({"type":"rated","id":1,"answers":{"tlx_mental":35}})",
    R"({"type":"ready","id":1,"trial":7})",
    R"({"type":"left","why":"focus"})",
    R"({"type":"frames","times_ms":[1,2.5]})",
    R"({"type":"stop","id":1,"keep":false})"};
const std::vector<std::string> kOfExperimenter = {
    R"({"type":"note","id":1,"text":"the light went out"})", R"({"type":"repeat","id":1})",
    R"({"type":"skip","id":1,"block":0,"place":1,"attempt":1})", R"({"type":"rearm","id":1})",
    R"({"type":"abort","id":1,"block":0,"place":1,"attempt":1})"};
const std::vector<std::string> kOfBoth = {R"({"type":"pause","id":1})",
                                          R"({"type":"go_on","id":1})"};

bool is_read(PageRole role, const std::string& text) {
  std::optional<std::uint64_t> id;
  return parse_live_request(role, text, id).ok();
}

TEST(LiveRequest, BelongsToItsRole) {
  for (const std::string& text : kOfParticipant) {
    EXPECT_TRUE(is_read(kParticipantPage, text)) << text;
    EXPECT_FALSE(is_read(kExperimenterPage, text)) << text;
  }
  for (const std::string& text : kOfExperimenter) {
    EXPECT_FALSE(is_read(kParticipantPage, text)) << text;
    EXPECT_TRUE(is_read(kExperimenterPage, text)) << text;
  }
  for (const std::string& text : kOfBoth) {
    EXPECT_TRUE(is_read(kParticipantPage, text)) << text;
    EXPECT_TRUE(is_read(kExperimenterPage, text)) << text;
  }
}

TEST(LiveRequest, HasItsKeysAndNoOthers) {
  for (const std::string& text : kOfParticipant) {
    const auto whole = nlohmann::json::parse(text);
    for (const auto& item : whole.items()) {
      if (item.key() == "id") continue;
      auto changed = whole;
      changed.erase(item.key());
      EXPECT_FALSE(is_read(kParticipantPage, changed.dump())) << changed;
      changed = whole;
      changed[item.key()] = nlohmann::json::array({nullptr});
      EXPECT_FALSE(is_read(kParticipantPage, changed.dump())) << changed;
    }
    auto changed = whole;
    changed["other"] = 1;
    EXPECT_FALSE(is_read(kParticipantPage, changed.dump())) << changed;
  }
}

TEST(LiveRequest, IsRefusedIfItIsTooLongOrTooDeep) {
  std::string numbers = "1";
  for (int i = 0; i < 100; ++i) numbers += ",1";
  const std::vector<std::string> wrong = {
      "",
      "[]",
      "1",
      "{",
      R"({"type":1})",
      R"({"type":"frames","times_ms":[)" + numbers + "]}",
      R"({"type":"next","step":")" + std::string(4001, 'a') + "\"}",
      R"({"type":"about","answers":{"age":{"a":"b"}}})",
      R"({"type":"rated","answers":{"real":1.5}})",
      R"({"type":"rated","answers":{"real":"1"}})",
      R"({"type":"ready","trial":-1})",
      R"({"type":"ready","trial":1.5})",
      R"({"type":"pause","id":-1})",
      std::string(100000, '['),
      R"({"type":"frames","times_ms":[1e999]})"};
  for (const std::string& text : wrong) {
    EXPECT_FALSE(is_read(kParticipantPage, text)) << text.substr(0, 100);
  }
}

TEST(LiveRequest, TellsTheIdOfAMessageThatIsRefused) {
  std::optional<std::uint64_t> id;
  EXPECT_FALSE(parse_live_request(kParticipantPage, R"({"type":"abort","id":12})", id).ok());
  EXPECT_EQ(id, 12u);
}

}  // namespace
}  // namespace palpate::test
