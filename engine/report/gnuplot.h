#pragma once

// The one place that runs gnuplot.

#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// What `set terminal svg` and the script draw, as an SVG document. The script says neither
// terminal nor output. Texts are UTF-8 and mean themselves: nothing in them is markup. The user's
// own settings of gnuplot have no effect, and no file has a name at any time.
//
// An error if gnuplot is not installed, or does not draw; what it said is in it. Blocks until
// gnuplot is done; not for the haptic thread.
Result<std::string> gnuplot_svg(const std::string& script, int width_px, int height_px,
                                int font_px);

// A string of gnuplot's language that stands for this text whatever is in it. Control characters
// become spaces, bytes that are no UTF-8 "?".
std::string gnuplot_quoted(std::string_view text);

// The same for the label of a tick, in which a percent sign would be a format.
std::string gnuplot_tick(std::string_view text);

}  // namespace palpate
