#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/plot.hpp"
#include "balance/mechanics/results/orders.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance::reports {
namespace {

constexpr double group_width = 0.8;  // of the distance between orders, for all bars of one order

/// Amplitudes of one colour, one per order.
struct BarSeries {
  std::string label;
  std::vector<double> amplitudes;
};

/// Amplitudes of a quantity that may have several components: of a vector as a whole its largest magnitude.
void add_series(const results::QuantityOrders& quantity, const std::string& label, VectorView view,
                std::vector<BarSeries>& series) {
  const auto orders = static_cast<Eigen::Index>(quantity.cosine.rows());
  const auto shown = [&](double amplitude) { return amplitude > quantity.round_off ? amplitude : 0; };
  if (quantity.components.empty() || view != VectorView::components) {
    BarSeries whole{view == VectorView::both && !quantity.components.empty() ? label + " magnitude" : label, {}};
    for (Eigen::Index n = 0; n < orders; ++n) whole.amplitudes.push_back(shown(quantity.peak(n)));
    series.push_back(std::move(whole));
  }
  if (view == VectorView::magnitude) return;
  for (std::size_t c = 0; c < quantity.components.size(); ++c) {
    BarSeries one{label.empty() ? quantity.components[c] : label + " " + quantity.components[c], {}};
    for (Eigen::Index n = 0; n < orders; ++n)
      one.amplitudes.push_back(shown(quantity.amplitude(n, static_cast<Eigen::Index>(c))));
    series.push_back(std::move(one));
  }
}

/// Rectangles of one series among `count` in each group.
PlotShape make_bars(const BarSeries& series, const std::vector<double>& orders, double spacing, std::size_t index,
                    std::size_t count, double unit) {
  const double width = group_width * spacing / static_cast<double>(count);
  PlotShape bars{series.label, make_line_style(index, 0), make_line_style(index, 0).colour, 1, true, {}};
  bars.pen.width = 0.3;
  for (std::size_t n = 0; n < orders.size(); ++n) {
    const double left = orders[n] - group_width * spacing / 2 + static_cast<double>(index) * width;
    const double height = series.amplitudes[n] / unit;
    bars.pieces.push_back({{left, 0}, {left, height}, {left + width, height}, {left + width, 0}});
  }
  return bars;
}

/// The quantities of a name: "shaking_force", "torque" with all actuators, "torque[A]".
std::vector<const results::QuantityOrders*> find_orders(const results::OrderAnalysis& analysis,
                                                        const std::string& name) {
  std::vector<const results::QuantityOrders*> found;
  for (const results::QuantityOrders& quantity : analysis.quantities)
    if (quantity.quantity == name || quantity.quantity.starts_with(name + "[")) found.push_back(&quantity);
  return found;
}

PlotPanel panel_of_orders(const std::vector<PlotRun>& runs, const std::vector<results::OrderAnalysis>& analyses,
                          const std::string& name, VectorView view, double spacing,
                          const specification::SpecUnits& units) {
  PlotPanel panel;
  panel.name = name;
  panel.from_zero = true;
  std::string unit;
  std::vector<BarSeries> series;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto found = find_orders(analyses[i], name);
    if (found.empty()) throw std::invalid_argument(fmt::format("{} has no orders of {}", runs[i].label, name));
    for (const results::QuantityOrders* quantity : found) {
      if (!unit.empty() && quantity->unit != unit)
        throw std::invalid_argument(
            fmt::format("{0} has different units: name one, such as {1}", name, found[0]->quantity));
      unit = quantity->unit;
      const std::size_t bracket = quantity->quantity.find('[');
      std::string label = found.size() > 1 && bracket != std::string::npos
                              ? quantity->quantity.substr(bracket + 1, quantity->quantity.size() - bracket - 2)
                              : "";
      if (runs.size() > 1) label = label.empty() ? runs[i].label : runs[i].label + ", " + label;
      add_series(*quantity, label, view, series);
    }
  }
  std::string title = name;
  std::replace(title.begin(), title.end(), '_', ' ');
  const files::DisplayUnit display = files::find_display_unit(unit, units);
  panel.y_label = title + bracket_unit(display);
  for (std::size_t i = 0; i < series.size(); ++i)
    panel.shapes.push_back(make_bars(series[i], analyses[0].orders, spacing, i, series.size(), display.factor));
  if (series.size() == 1) panel.shapes[0].label.clear();
  return panel;
}

}  // namespace

Plot plot_orders(const std::vector<PlotRun>& runs, const std::vector<std::string>& quantities, int highest,
                 VectorView view, const specification::SpecUnits& units) {
  std::vector<results::OrderAnalysis> analyses;
  for (const PlotRun& run : runs) {
    analyses.push_back(results::analyse_orders(*run.result, highest));
    if (analyses.back().orders != analyses[0].orders)
      throw std::invalid_argument(fmt::format("{} makes another number of turns than {}", run.label, runs[0].label));
  }
  Plot picture;
  picture.x_label = fmt::format("order of {}", analyses[0].turning.coordinate);
  for (const std::string& name : quantities) {
    picture.panels.push_back(panel_of_orders(runs, analyses, name, view, analyses[0].orders[0], units));
    picture.panels.back().legend = picture.panels.back().shapes.size() > 1;
  }
  return picture;
}

}  // namespace balance::reports
