// The writer of pictures: its bytes, its texts and its ticks.

#include "engine/report/svg.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "geometry/base/random.h"

namespace palpate {
namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(SvgPicture, ShowsTextsAsTheyAre) {
  SvgPicture svg(100.0, 50.0, 13.0);
  svg.text({1.0, 2.0}, "<script>alert(1)</script> & \"a\"\n\xff 'µ'");
  svg.text({1.0, 2.0}, "");
  const std::string document = svg.document();
  EXPECT_TRUE(has(document, ">&lt;script&gt;alert(1)&lt;/script&gt; &amp; \"a\" ? 'µ'</text>"))
      << document;
  EXPECT_EQ(document.find("<text"), document.rfind("<text")) << "no element for an empty text";
}

TEST(SvgPicture, WritesEveryNumberWithTwoDecimals) {
  SvgPicture svg(100.0, 50.0, 13.0);
  svg.lines(std::vector<SvgLine>{{{0.0, 1e-9}, {-1e-9, 1.0 / 3.0}}, {{1e7, -0.005001}, {2.0, 3.0}}},
            {kSvgBlue, 1.5, "7 4"});
  svg.line({}, {});
  const std::string document = svg.document();
  EXPECT_TRUE(has(document, "d=\"M0.00,0.00L0.00,0.33M10000000.00,-0.01L2.00,3.00\"")) << document;
  EXPECT_TRUE(has(document, "stroke=\"#0072B2\" stroke-width=\"1.50\" stroke-dasharray=\"7 4\""));
  EXPECT_EQ(document.find("<path"), document.rfind("<path")) << "no element for an empty line";
}

TEST(SvgPicture, HasAGroundOfItsOwnForBothColourSchemes) {
  const std::string document = SvgPicture(100.0, 50.0, 13.0).document();
  EXPECT_TRUE(has(document, "fill=\"#ffffff\"")) << "for programs without style sheets";
  EXPECT_TRUE(has(document, "@media(prefers-color-scheme:dark)"));
  EXPECT_TRUE(has(document, "fill=\"currentColor\""));
}

TEST(SvgPicture, APanelIsClosed) {
  SvgPicture svg(100.0, 50.0, 13.0);
  svg.begin_panel({10.0, 20.0, 60.0, 40.0});
  svg.spot({5.0, 5.0});
  svg.end_panel();
  const std::string document = svg.document();
  EXPECT_TRUE(has(document,
                  "<svg x=\"10.00\" y=\"20.00\" width=\"50.00\" height=\"20.00\" "
                  "viewBox=\"0 0 50.00 20.00\">"));
  EXPECT_TRUE(document.ends_with("</svg>\n</svg>\n"));
}

TEST(RoundTicks, AreWhereTheirLabelsSay) {
  const std::uint64_t seed = 50;
  std::printf("seed %d\n", static_cast<int>(seed));
  SeededRandom random(seed);
  for (int n = 0; n < 2000; ++n) {
    const double span = std::pow(10.0, random.uniform(-9.0, 6.0));
    const double low = random.uniform(-2.0, 1.0) * span;
    const auto ticks = round_ticks(low, low + span);
    EXPECT_GE(ticks.size(), 2u) << low << " " << span;
    EXPECT_LE(ticks.size(), 7u) << low << " " << span;
    for (const SvgTick& tick : ticks) {
      EXPECT_GE(tick.at, low);
      EXPECT_LE(tick.at, low + span);
      EXPECT_NEAR(std::strtod(tick.label.c_str(), nullptr), tick.at, 1e-9 * span);
      EXPECT_NE(tick.label, "-0");
    }
  }
}

// The span is below the resolution of a double there.
TEST(RoundTicks, EndWhereNoTickFits) {
  EXPECT_LE(round_ticks(2.0, 2.0 + 4e-16).size(), 7u);
}

}  // namespace
}  // namespace palpate
