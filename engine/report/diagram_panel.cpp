#include "engine/report/diagram_panel.h"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/report/gnuplot.h"
#include "engine/report/human_units.h"

namespace palpate {
namespace {

constexpr double kLegendTop = kPanelArea.bottom + 64.0;
constexpr double kLegendRow = 23.0;
constexpr double kBottomMargin = 8.0;

// Characters; longer texts are cut.
constexpr std::size_t kLongestLegendOfTwo = 25;  // in two columns
constexpr std::size_t kLongestAxisLine = 42;

// One colour for each effect. The first six are those of Okabe and Ito, which colour-blind readers
// can distinguish. The points are gnuplot's filled symbols; the number before each is that of its
// open symbol.
constexpr std::array kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
                                 "#332288", "#882255", "#999933", "#8C510A", "#6B6B6B", "#44AA99"};
constexpr std::array kFilledPoints = {7, 5, 9, 11, 13, 15};

}  // namespace

std::string PanelPlace::screen(double x, double y) const {
  std::ostringstream out;
  out << "screen " << (left + x) / width << ", screen " << 1.0 - (top + y) / height;
  return out.str();
}

const char* curve_colour(std::size_t curve) {
  return kColours[curve % kColours.size()];
}
int curve_point(std::size_t curve) {
  return kFilledPoints[(curve + curve / kColours.size()) % kFilledPoints.size()];
}

std::string curve_style(std::size_t curve) {
  std::ostringstream out;
  out << "linespoints lw 2 pt " << curve_point(curve) << " ps 0.9 lc rgb '" << curve_colour(curve)
      << "'";
  return out.str();
}

std::string shortened_label(const std::string& text, std::size_t longest) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80;
    if (begins && ++characters > longest) return text.substr(0, i) + "…";
  }
  return text;
}

int legend_rows(const std::vector<LegendEntry>& entries) {
  const bool narrow = std::all_of(entries.begin(), entries.end(), [](const LegendEntry& e) {
    return text_width_px(e.title, 1.0) <= text_width_px(std::string(kLongestLegendOfTwo, 'x'), 1.0);
  });
  const int count = static_cast<int>(entries.size());
  return narrow ? (count + 1) / 2 : count;
}

double panel_height(int rows) {
  return kLegendTop + rows * kLegendRow + kBottomMargin;
}

std::string data_row(std::initializer_list<double> numbers) {
  std::ostringstream out;
  out.precision(9);
  for (const double number : numbers) out << number << " ";
  out << "\n";
  return out.str();
}

DiagramPanel::DiagramPanel(const PlotAxis& x, const PlotAxis& y, const PanelPlace& place,
                           std::string block_prefix)
    : x_(x), y_(y), place_(place), block_prefix_(std::move(block_prefix)), places_(kPanelArea) {
  out_.precision(9);
  plots_.precision(9);
}

double DiagramPanel::x_px(double position) const {
  return kPanelArea.left +
         (kPanelArea.right - kPanelArea.left) * (position - x_.begin()) / (x_.end() - x_.begin());
}

double DiagramPanel::y_px(double position) const {
  return kPanelArea.bottom -
         (kPanelArea.bottom - kPanelArea.top) * (position - y_.begin()) / (y_.end() - y_.begin());
}

void DiagramPanel::put_frame() {
  const auto across = [&](double px) { return (place_.left + px) / place_.width; };
  const auto up = [&](double px) { return 1.0 - (place_.top + px) / place_.height; };
  out_ << "set lmargin at screen " << across(kPanelArea.left) << "\nset rmargin at screen "
       << across(kPanelArea.right) << "\nset tmargin at screen " << up(kPanelArea.top)
       << "\nset bmargin at screen " << up(kPanelArea.bottom) << "\n"
       << "set grid lc rgb '#E4E4E4' lw 1\nset border lc rgb '#404040'\nset clip two\n"
       << "set tics scale 0.7,0.35\nset xtics nomirror\nset ytics nomirror\n";
}

void DiagramPanel::put_ticks(const char* axis, const PlotAxis& of) {
  out_ << "set " << axis << " (";
  const char* separator = "";
  for (const PlotAxis::Tick& tick : of.ticks()) {
    out_ << separator << gnuplot_tick(tick.label) << " " << tick.position
         << (tick.label.empty() ? " 1" : "");
    separator = ", ";
  }
  out_ << ")\n";
}

// gnuplot itself would place the label beside the widest tick label, which can be outside the
// panel.
void DiagramPanel::put_upright_label(const std::string& name) {
  const std::string text = with_unit(name, y_.unit());
  constexpr double kLinePx = 17.0, kRightPx = 34.0;
  std::vector<std::string> lines = {text};
  const std::size_t middle = text.rfind(' ', text.size() / 2 + 1);
  if (text.size() > kLongestAxisLine && middle != std::string::npos) {
    lines = {text.substr(0, middle), text.substr(middle + 1)};
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double px = kRightPx - kLinePx * static_cast<double>(lines.size() - 1 - i);
    out_ << "set label " << gnuplot_quoted(shortened_label(lines[i], kLongestAxisLine)) << " at "
         << place_.screen(px, 0.5 * (kPanelArea.top + kPanelArea.bottom)) << " center rotate\n";
  }
}

void DiagramPanel::put_axes(const std::string& title, const std::string& across_name,
                            const std::string& up_name) {
  out_ << "set xrange [" << x_.begin() << ":" << x_.end() << "]\nset yrange [" << y_.begin() << ":"
       << y_.end() << "]\n";
  put_ticks("xtics", x_);
  put_ticks("ytics", y_);
  out_ << "set xlabel "
       << gnuplot_quoted(with_unit(shortened_label(across_name, kLongestAxisLine), x_.unit()))
       << " offset 0,0.4\nset title '" << title << "' offset 0,-0.4\n";
  put_upright_label(up_name);
}

void DiagramPanel::put_zero_bands() {
  const auto band = [&](const std::string& from, const std::string& to) {
    out_ << "set object rectangle from " << from << " to " << to
         << " fc rgb '#F0F0F0' fs noborder behind\n";
  };
  const auto text = [](double number) {
    std::ostringstream out;
    out.precision(9);
    out << number;
    return out.str();
  };
  if (y_.zero_band()) {
    band("graph 0, graph 0", "graph 1, first " + text(*y_.zero_band()));
  }
  if (x_.zero_band()) {
    band("graph 0, graph 0", "first " + text(*x_.zero_band()) + ", graph 1");
  }
}

void DiagramPanel::put_label(const std::string& text, const PixelBox& box, const char* colour) {
  out_ << "set label " << gnuplot_quoted(text) << " at "
       << place_.screen(0.5 * (box.left + box.right), 0.5 * (box.top + box.bottom))
       << " center font ',12' textcolor rgb '" << colour << "' front\n";
}

void DiagramPanel::put_line_across(double position) {
  out_ << "set arrow from graph 0, first " << position << " to graph 1, first " << position
       << " nohead dt (8,5) lw 1.5 lc rgb '#707070'\n";
}

void DiagramPanel::put_block(const std::string& rows, const std::string& plot) {
  if (rows.empty()) return;
  const std::string name = block_prefix_ + std::to_string(++block_count_);
  out_ << name << " << EOD\n" << rows << "EOD\n";
  plots_ << ", \\\n  " << name << " " << plot << " notitle";
}

void DiagramPanel::put_legend(const std::vector<LegendEntry>& entries) {
  const int rows = legend_rows(entries);
  out_ << "set key at " << place_.screen(kPanelArea.left - 78.0, kLegendTop)
       << " left top Left reverse vertical maxrows " << rows << " samplen 2.2 spacing 1.1\n";
  for (const LegendEntry& entry : entries) {
    plots_ << ", \\\n  keyentry with " << entry.style << " title " << gnuplot_quoted(entry.title);
  }
}

std::string DiagramPanel::script() const {
  return out_.str() + "plot NaN notitle" + plots_.str() +
         "\nunset label\nunset arrow\nunset object\n";
}

}  // namespace palpate
