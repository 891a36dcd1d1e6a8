#pragma once

// Runs gnuplot; no other part of the program does.

#include <string>
#include <string_view>

#include "geometry/base/result.h"

namespace palpate {

// The SVG document that gnuplot draws from the script with `set terminal svg`. The script sets
// neither terminal nor output. Texts are UTF-8 and literal: no character in them is markup. The
// user's gnuplot settings have no effect. Temporary files never have a name.
//
// Returns an error if gnuplot is not installed or does not draw; the error contains gnuplot's
// message. Blocks until gnuplot exits; not for the haptic thread.
Result<std::string> gnuplot_svg(const std::string& script, int width_px, int height_px,
                                int font_px);

// A gnuplot string literal for this text, whatever characters it contains. Control characters
// become spaces; bytes that are not UTF-8 become "?".
std::string gnuplot_quoted(std::string_view text);

// A gnuplot string literal for a tick label. It also escapes percent signs, because gnuplot
// interprets a percent sign in a tick label as a format.
std::string gnuplot_tick(std::string_view text);

}  // namespace palpate
