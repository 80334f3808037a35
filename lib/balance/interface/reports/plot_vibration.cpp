#include "balance/interface/reports/plot_vibration.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace balance::reports {

using vibration::ForcedResponse;
using vibration::SweepPoint;

namespace {

constexpr double max_order_headroom = 1.25;  // lines of orders end above the highest frequency of a mode
constexpr double min_shown_share = 1e-4;     // of the largest order of a quantity: smaller ones are not drawn
constexpr const char* order_colour = "#9aa1a9";

const ForcedResponse* find_response(const std::vector<SweepPoint>& points) {
  for (const SweepPoint& point : points)
    if (point.response && !point.response->linear.empty()) return &*point.response;
  return nullptr;
}

class SweepPlot {
 public:
  SweepPlot(const VibrationReportData& view, const specification::SpecUnits& units)
      : view_(view), points_(view.sweep->points), units_(units), response_(find_response(points_)) {}

  Plot draw() {
    plot_.x_label = view_.swept.name + (view_.swept.unit.empty() ? "" : " [" + view_.swept.unit + "]");
    add_frequencies();
    add_growth();
    if (response_ == nullptr) return std::move(plot_);
    for (std::size_t q = 0; q < response_->linear.size(); ++q)
      if (response_->linear[q].quantity.starts_with("joint_position")) add_amplitudes(q);
    add_transmissibility();
    std::erase_if(plot_.panels, [](const PlotPanel& panel) { return panel.lines.empty(); });
    return std::move(plot_);
  }

 private:
  PlotPanel& add_panel(const std::string& name, const std::string& heading, const std::string& unit) {
    plot_.panels.push_back({.name = name, .heading = heading, .y_label = unit.empty() ? "" : "[" + unit + "]"});
    return plot_.panels.back();
  }

  /// A line for the smallest number of every point, one for the next, and so on.
  void add_ranked_lines(PlotPanel& panel, const std::string& label, std::size_t colour,
                        std::vector<std::vector<double>> numbers) const {
    std::size_t count = 0;
    for (std::vector<double>& at_point : numbers) {
      std::sort(at_point.begin(), at_point.end());
      count = std::max(count, at_point.size());
    }
    for (std::size_t k = 0; k < count; ++k) {
      PlotLine line{k == 0 ? label : "", make_line_style(colour, 0), {}};
      for (std::size_t p = 0; p < points_.size(); ++p)
        if (numbers[p].size() > k) line.points.push_back({points_[p].value, numbers[p][k]});
      panel.lines.push_back(std::move(line));
    }
  }

  void add_frequencies() {
    PlotPanel& panel =
        add_panel("frequency", response_ ? "frequencies of modes and orders" : "frequencies of modes", "Hz");
    panel.from_zero = true;
    double highest = 0;
    std::vector<std::vector<double>> frequencies;
    for (const SweepPoint& point : points_) {
      frequencies.emplace_back();
      for (const vibration::VibrationMode& mode : point.modes.modes)
        if (mode.oscillates()) frequencies.back().push_back(mode.frequency());
      for (const double frequency : frequencies.back()) highest = std::max(highest, frequency);
    }
    add_ranked_lines(panel, "modes", 0, std::move(frequencies));
    if (response_ != nullptr)
      for (std::size_t n = 0; n < response_->orders.size(); ++n) {
        PlotLine line{fmt::format("order {:g}", response_->orders[n]), make_line_style(0, n), {}};
        line.pen.colour = order_colour;
        for (const SweepPoint& point : points_) {
          if (!point.response) continue;
          const double frequency =
              response_->orders[n] * std::abs(point.response->turning.speed) / (2 * std::numbers::pi);
          if (frequency <= max_order_headroom * highest) line.points.push_back({point.value, frequency});
        }
        if (line.points.size() > 1) panel.lines.push_back(std::move(line));
      }
  }

  void add_growth() {
    PlotPanel& panel = add_panel("growth", "real parts of eigenvalues", "1/s");
    std::vector<std::vector<double>> real_parts;
    for (const SweepPoint& point : points_) {
      real_parts.emplace_back();
      for (const std::complex<double> value : point.modes.eigenvalues) real_parts.back().push_back(value.real());
    }
    add_ranked_lines(panel, "eigenvalues", 1, std::move(real_parts));
    if (view_.sweep->stability_changes.empty()) return;
    PlotMarker changes{"stability changes", MarkerShape::circle, make_line_style(0, 0).colour, {}};
    for (const vibration::StabilityChange& change : view_.sweep->stability_changes)
      changes.points.push_back({change.value, 0});
    panel.marks.push_back(std::move(changes));
  }

  void add_amplitudes(std::size_t q) {
    const files::DisplayUnit unit = files::find_display_unit(response_->linear[q].unit, units_);
    PlotPanel& panel =
        add_panel(response_->linear[q].quantity, response_->linear[q].quantity + ", peak of every order", unit.name);
    panel.from_zero = true;
    PlotMarker exact{"exact", MarkerShape::circle, order_colour, {}};
    double largest = 0;
    for (std::size_t n = 0; n < response_->orders.size(); ++n)
      for (const PlotPoint& point : trace(q, n, unit)) largest = std::max(largest, point.y);
    for (std::size_t n = 0; n < response_->orders.size(); ++n) {
      PlotLine line{fmt::format("order {:g}", response_->orders[n]), make_line_style(n, n), trace(q, n, unit)};
      const bool is_shown = std::any_of(line.points.begin(), line.points.end(),
                                        [&](const PlotPoint& point) { return point.y > min_shown_share * largest; });
      if (!is_shown) continue;
      panel.lines.push_back(std::move(line));
      for (const SweepPoint& point : points_)
        if (point.response && point.response->exact.size() > q)
          exact.points.push_back(
              {point.value, unit.convert(point.response->exact[q].peak(static_cast<Eigen::Index>(n)))});
    }
    if (!exact.points.empty()) panel.marks.push_back(std::move(exact));
  }

  std::vector<PlotPoint> trace(std::size_t q, std::size_t n, const files::DisplayUnit& unit) const {
    std::vector<PlotPoint> points;
    for (const SweepPoint& point : points_)
      if (point.response && point.response->linear.size() > q)
        points.push_back({point.value, unit.convert(point.response->linear[q].peak(static_cast<Eigen::Index>(n)))});
    return points;
  }

  void add_transmissibility() {
    PlotPanel panel{.name = "transmissibility", .heading = "transmissibility of the ground force", .y_label = "[1]"};
    panel.from_zero = true;
    for (std::size_t n = 0; n < response_->orders.size(); ++n) {
      PlotLine line{fmt::format("order {:g}", response_->orders[n]), make_line_style(n, n), {}};
      for (const SweepPoint& point : points_) {
        if (!point.response) continue;
        const double ratio = point.response->transmissibility(static_cast<Eigen::Index>(n));
        if (std::isfinite(ratio)) line.points.push_back({point.value, ratio});
      }
      if (line.points.size() > 1) panel.lines.push_back(std::move(line));
    }
    if (!panel.lines.empty()) plot_.panels.push_back(std::move(panel));
  }

  const VibrationReportData& view_;
  const std::vector<SweepPoint>& points_;
  const specification::SpecUnits& units_;
  const ForcedResponse* response_;
  Plot plot_;
};

}  // namespace

Plot plot_sweep(const VibrationReportData& view, const specification::SpecUnits& units) {
  return SweepPlot(view, units).draw();
}

}  // namespace balance::reports
