#pragma once

// Writes the gnuplot script of one panel of a diagram with logarithmic axes: its frame, axes,
// texts, data blocks and legend.

#include <cstddef>
#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"

namespace palpate {

// The width of a panel, and the data area within the panel, in pixels. Below the data area are the
// ticks and the label of the horizontal axis, and the legend.
inline constexpr double kPanelWidth = 516.0;
inline constexpr PixelBox kPanelArea = {98.0, 34.0, 494.0, 364.0};
inline constexpr int kPanelFontPx = 14;

// The upper left corner of a panel on its canvas, and the size of the canvas. Pixels.
struct PanelPlace {
  double left = 0.0, top = 0.0;
  double width = 0.0, height = 0.0;  // size of the canvas

  // Converts a point of the panel (pixels from its upper left corner, y downwards) to gnuplot's
  // `screen` coordinates.
  std::string screen(double x, double y) const;
};

// The colour, the point symbol and the complete gnuplot style of the n-th curve (n = 0, 1, ...). A
// point symbol is given by its number in gnuplot. This number denotes the filled symbol, and the
// number before it denotes the open symbol.
const char* curve_colour(std::size_t curve);
int curve_point(std::size_t curve);
std::string curve_style(std::size_t curve);

// Cuts a UTF-8 text after `longest` characters and marks the cut with an ellipsis, which is not
// counted. A text that is not longer is returned unchanged.
std::string shortened_label(const std::string& text, std::size_t longest);

// An entry of the legend: its text and the gnuplot style of the line sample beside the text.
struct LegendEntry {
  std::string title;
  std::string style;
};

// The number of lines of a legend that has these entries. The entries are in two columns if every
// title is short enough, otherwise in one.
int legend_rows(const std::vector<LegendEntry>& entries);
// The height in pixels of a panel whose legend has `rows` lines.
double panel_height(int rows);

// Formats these numbers as one line of a data block.
std::string data_row(std::initializer_list<double> numbers);

// Collects the parts of a panel. Each put_ function adds one part, and script() returns the parts
// in the order in which gnuplot reads them. The axes must outlive the panel.
class DiagramPanel {
 public:
  // block_prefix: the prefix of the names of this panel's data blocks, such as "$t". No other panel
  // of the script may have the same prefix.
  DiagramPanel(const PlotAxis& x, const PlotAxis& y, const PanelPlace& place,
               std::string block_prefix);

  // Convert a position on the horizontal or the vertical axis (PlotAxis::at) to pixels in the
  // panel.
  double x_px(double position) const;
  double y_px(double position) const;
  // The places for labels, in the parts of the data area that are not occupied.
  LabelPlaces& places() { return places_; }

  void put_frame();
  void put_axes(const std::string& title, const std::string& across_name,
                const std::string& up_name);
  void put_zero_bands();
  void put_label(const std::string& text, const PixelBox& box, const char* colour);
  // Adds a dashed horizontal line at a position on the vertical axis.
  void put_line_across(double position);
  // Adds a data block with these rows, and the entry "$block PLOT" to the plot command. Adds
  // neither if `rows` is empty.
  void put_block(const std::string& rows, const std::string& plot);
  void put_legend(const std::vector<LegendEntry>& entries);

  std::string script() const;

 private:
  void put_ticks(const char* axis, const PlotAxis& of);
  void put_upright_label(const std::string& name);

  const PlotAxis& x_;
  const PlotAxis& y_;
  PanelPlace place_;
  std::string block_prefix_;
  LabelPlaces places_;
  std::ostringstream out_;    // the script before the plot command
  std::ostringstream plots_;  // the entries of the plot command
  int block_count_ = 0;
};

}  // namespace palpate
