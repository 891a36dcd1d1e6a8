#pragma once

// One panel of a diagram on logarithmic axes, as a gnuplot script: its frame, axes, texts, data
// blocks and legend.

#include <cstddef>
#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "engine/report/label_places.h"
#include "engine/report/plot_axis.h"

namespace palpate {

// Pixels. The width of a panel and the data area within it; ticks, axis label and legend are below
// the data area.
inline constexpr double kPanelWidth = 516.0;
inline constexpr PixelBox kPanelArea = {98.0, 34.0, 494.0, 364.0};
inline constexpr int kPanelFontPx = 14;

// The position of a panel on its canvas, pixels.
struct PanelPlace {
  double left = 0.0, top = 0.0;
  double width = 0.0, height = 0.0;  // of the canvas

  // gnuplot's `screen` coordinates of a point of the panel.
  std::string screen(double x, double y) const;
};

// For the n-th curve: its colour; the number of its filled point symbol, which follows that of the
// open one; its whole gnuplot style.
const char* curve_colour(std::size_t curve);
int curve_point(std::size_t curve);
std::string curve_style(std::size_t curve);

// The text cut to at most this many characters; an ellipsis marks a cut. UTF-8.
std::string shortened_label(const std::string& text, std::size_t longest);

// A line of the legend: its text and the gnuplot style of its sample.
struct LegendEntry {
  std::string title;
  std::string style;
};

// The number of lines of the legend; half as many if two columns fit.
int legend_rows(const std::vector<LegendEntry>& entries);
// The height of a panel whose legend has this many lines, pixels.
double panel_height(int rows);

// One line of a data block.
std::string data_row(std::initializer_list<double> numbers);

// Collects the parts of a panel in the order in which gnuplot reads them. The axes must outlive the
// panel.
class DiagramPanel {
 public:
  // block_prefix: prefix of the names of its data blocks ("$t"), unique within the script.
  DiagramPanel(const PlotAxis& x, const PlotAxis& y, const PanelPlace& place,
               std::string block_prefix);

  // The pixel of a position on an axis, in the panel.
  double x_px(double position) const;
  double y_px(double position) const;
  // The occupied parts of the data area.
  LabelPlaces& places() { return places_; }

  void put_frame();
  void put_axes(const std::string& title, const std::string& across_name,
                const std::string& up_name);
  void put_zero_bands();
  void put_label(const std::string& text, const PixelBox& box, const char* colour);
  // A dashed horizontal line at a position of the vertical axis.
  void put_line_across(double position);
  // A data block; unless it is empty, the plot command gets the entry "$block PLOT".
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
