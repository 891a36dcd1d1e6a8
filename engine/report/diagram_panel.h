#pragma once

// One panel of a diagram on logarithmic axes, as a script for gnuplot: its frame, axes, texts,
// blocks of data and legend.

#include <cstddef>
#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"

namespace palpate {

// Pixels. A panel, and within it the area of data; what is below is for ticks, label and legend.
inline constexpr double kPanelWidth = 516.0;
inline constexpr PixelBox kPanelArea = {98.0, 34.0, 494.0, 364.0};
inline constexpr int kPanelFontPx = 14;

// Where a panel is on its canvas, pixels.
struct PanelPlace {
  double left = 0.0, top = 0.0;
  double width = 0.0, height = 0.0;  // of the canvas

  // gnuplot's `screen` coordinates of a point of the panel.
  std::string screen(double x, double y) const;
};

// Of the n-th curve: the colour, the filled point, whose open one comes before, and all that draws
// it.
const char* curve_colour(std::size_t curve);
int curve_point(std::size_t curve);
std::string curve_style(std::size_t curve);

// Cut to so many characters, with a mark. UTF-8.
std::string shortened_label(const std::string& text, std::size_t longest);

// A line of the legend and what it draws there.
struct LegendEntry {
  std::string title;
  std::string style;
};

// Lines that the legend takes: half as many where there is room for two columns.
int legend_rows(const std::vector<LegendEntry>& entries);
// Of a panel with so many.
double panel_height(int rows);

// A line of a block of data.
std::string data_row(std::initializer_list<double> numbers);

// Parts are put in the order in which gnuplot is to read them. The axes must outlive the panel.
class DiagramPanel {
 public:
  // block_prefix: of the names of its blocks ("$t"), which no other panel of the script has.
  DiagramPanel(const PlotAxis& x, const PlotAxis& y, const PanelPlace& place,
               std::string block_prefix);

  // Where a position on an axis is in the panel.
  double x_px(double position) const;
  double y_px(double position) const;
  // What is taken already of the area of data.
  LabelPlaces& places() { return places_; }

  void put_frame();
  void put_axes(const std::string& title, const std::string& across_name,
                const std::string& up_name);
  void put_zero_bands();
  void put_label(const std::string& text, const PixelBox& box, const char* colour);
  // A broken line at a position of the upright axis.
  void put_line_across(double position);
  // A block of data; `plot` goes into the plot command as "$block PLOT" unless the block is empty.
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
  std::ostringstream out_;    // all before the plot command
  std::ostringstream plots_;  // what that draws
  int block_count_ = 0;
};

}  // namespace palpate
