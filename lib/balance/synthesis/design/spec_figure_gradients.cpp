#include "balance/synthesis/design/spec_figure_gradients.hpp"

#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/run_quantities.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::design {

using derivatives::FigureGradient;

namespace {

std::size_t index_of(const DesignSpace& space, const std::string& trajectory) {
  const std::size_t index = trajectory_index(space.start, trajectory);
  if (is_mechanism_dependent(space.start.trajectories[index]))
    throw std::invalid_argument("the trajectory '" + trajectory + "' is recomputed for every mechanism");
  return index;
}

/// A figure of a quantity and the position of its derivatives in a FigureGradient.
struct FigureSlot {
  ValueWithGradient QuantityGradients::*slope;
  double FigureGradient::*value;
  std::array<double, numerics::dual_width> FigureGradient::*derivatives;
};
constexpr FigureSlot figure_slots[] = {{&QuantityGradients::peak, &FigureGradient::peak, &FigureGradient::d_peak},
                                       {&QuantityGradients::rms, &FigureGradient::rms, &FigureGradient::d_rms},
                                       {&QuantityGradients::mean, &FigureGradient::mean, &FigureGradient::d_mean},
                                       {&QuantityGradients::range, &FigureGradient::range, &FigureGradient::d_range}};

class FigureDifferentiation {
 public:
  FigureDifferentiation(const DesignSpace& space, const VectorX& x, std::size_t trajectory,
                        const std::vector<std::string>& quantities, const std::vector<std::string>& arrays)
      : space_(space), x_(x), trajectory_(trajectory), requested_(quantities), arrays_(arrays) {}

  SpecFigureGradients run() {
    for (Eigen::Index first = 0; first == 0 || first < x_.size(); first += numerics::dual_width)
      if (!differentiate(first, std::min<Eigen::Index>(x_.size(), first + numerics::dual_width))) break;
    return std::move(out_);
  }

 private:
  /// The values of the spec, with derivatives by the inputs `first` to `last`.
  study::RecordedValues<derivatives::DualNumber> derived_by(Eigen::Index first, Eigen::Index last) const {
    std::vector<derivatives::DualNumber> inputs(space_.inputs.begin(), space_.inputs.end());
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      derivatives::DualNumber& input =
          inputs[static_cast<std::size_t>(space_.free_inputs[static_cast<std::size_t>(i)])];
      input = x_[i];
      if (i >= first && i < last) input.d[static_cast<std::size_t>(i - first)] = 1;
    }
    return {*space_.recording, inputs};
  }

  /// @return whether there is a run
  bool differentiate(Eigen::Index first, Eigen::Index last) {
    const study::RecordedValues<derivatives::DualNumber> values = derived_by(first, last);
    const auto trajectory =
        trajectory::cast_scalar<derivatives::DualNumber>(space_.recording->trajectories[trajectory_], values);
    MechanismOf<derivatives::DualNumber> mechanism = values.mechanism();
    if (space_.assembly_mode) study::set_assembly(mechanism, space_.instantiate(x_).mechanism.assembly);
    const derivatives::RunGradient gradient = derivatives::differentiate_run(mechanism, trajectory, arrays_);
    out_.outcome = gradient.run.outcome;
    if (gradient.run.outcome.status != MotionStatus::done) return false;
    if (out_.quantities.empty()) name_quantities(gradient.run);
    copy_gradients(differentiate_figures(gradient, further_), first, last);
    return true;
  }

  /// Lists the quantities that have figures; each is the worst of a range of the gradient's figures.
  void name_quantities(const RunResult& run) {
    const std::vector<results::MetricSeries> series = list_metric_series(run);
    const ValueWithGradient unknown{0, VectorX::Zero(x_.size())};
    const auto add = [&](const std::string& quantity, std::size_t first, std::size_t last) {
      out_.quantities.push_back({quantity, unknown, unknown, unknown, unknown, {}, {}});
      members_.emplace_back(first, last);
    };
    for (const auto& [first, last] : group_metric_series(series)) {
      if (!series[first].worst_group.empty()) add(series[first].worst_group, first, last);
      for (std::size_t i = first; i < last; ++i) add(series[i].quantity, i, i + 1);
    }
    for (const std::string& name : requested_) {
      if (find_quantity(out_, name) != nullptr) continue;
      const auto is_member = [&](const results::MetricSeries& one) { return one.quantity.starts_with(name + "["); };
      if (const auto member = std::find_if(series.begin(), series.end(), is_member); member != series.end()) {
        const auto last = std::find_if_not(member, series.end(), is_member);
        add(name, static_cast<std::size_t>(member - series.begin()), static_cast<std::size_t>(last - series.begin()));
      } else if (std::optional<results::MetricSeries> one = find_series(run, name)) {
        further_.push_back(std::move(*one));
        const std::size_t index = series.size() + further_.size() - 1;
        add(name, index, index + 1);
      }
    }
    out_.energy = out_.duration = unknown;
  }

  void copy_gradients(const derivatives::FigureGradients& gradients, Eigen::Index from, Eigen::Index to) {
    const auto copy = [&](const std::array<double, numerics::dual_width>& derivatives, ValueWithGradient& slope) {
      for (Eigen::Index i = from; i < to; ++i) slope.gradient[i] = derivatives[static_cast<std::size_t>(i - from)];
    };
    for (std::size_t q = 0; q < members_.size(); ++q) {
      const auto first = gradients.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].first);
      const auto last = gradients.figures.begin() + static_cast<std::ptrdiff_t>(members_[q].second);
      for (const FigureSlot& slot : figure_slots) {
        const FigureGradient& worst = *std::max_element(
            first, last,
            [&](const FigureGradient& a, const FigureGradient& b) { return a.*slot.value < b.*slot.value; });
        ValueWithGradient& slope = out_.quantities[q].*slot.slope;
        slope.value = worst.*slot.value;
        copy(worst.*slot.derivatives, slope);
      }
      const auto add = [&](const std::vector<derivatives::Extreme> FigureGradient::*extremes,
                           std::vector<ValueWithGradient>& slopes) {
        std::size_t k = 0;
        for (auto member = first; member != last; ++member)
          for (const derivatives::Extreme& extreme : (*member).*extremes) {
            if (k == slopes.size()) slopes.push_back({0, VectorX::Zero(x_.size())});
            slopes[k].value = extreme.value;
            copy(extreme.d, slopes[k++]);
          }
      };
      add(&FigureGradient::highest, out_.quantities[q].segment_maxima);
      add(&FigureGradient::lowest, out_.quantities[q].segment_minima);
    }
    out_.energy.value = gradients.energy;
    copy(gradients.d_energy, out_.energy);
    out_.duration.value = gradients.duration;
    copy(gradients.d_duration, out_.duration);
  }

  const DesignSpace& space_;
  const VectorX& x_;
  std::size_t trajectory_;
  const std::vector<std::string>&requested_, &arrays_;
  std::vector<results::MetricSeries> further_;  ///< requested quantities without metrics
  SpecFigureGradients out_;
  std::vector<std::pair<std::size_t, std::size_t>> members_;  ///< per quantity: range of the gradient's figures
};

/// "torque[A1]" belongs to the array "torque", and "force[S]" to "force".
std::vector<std::string> arrays_of(const std::vector<std::string>& quantities) {
  std::vector<std::string> arrays;
  for (const std::string& quantity : quantities) arrays.push_back(results::effort_array_name(quantity));
  return arrays;
}

}  // namespace

SpecFigureGradients compute_figure_gradients(const DesignSpace& space, const VectorX& x, const std::string& trajectory,
                                             const std::vector<std::string>& quantities) {
  if (x.size() != static_cast<Eigen::Index>(space.free_inputs.size()))
    throw std::invalid_argument("expected " + std::to_string(space.free_inputs.size()) +
                                " values of free numbers, found " + std::to_string(x.size()));
  const std::vector<std::string> arrays = arrays_of(quantities);
  return FigureDifferentiation(space, x, index_of(space, trajectory), quantities, arrays).run();
}

const QuantityGradients* find_quantity(const SpecFigureGradients& slopes, const std::string& quantity) {
  const auto found =
      std::find_if(slopes.quantities.begin(), slopes.quantities.end(),
                   [&](const QuantityGradients& one) { return results::is_quantity_name(quantity, one.quantity); });
  return found == slopes.quantities.end() ? nullptr : &*found;
}

}  // namespace balance::design
