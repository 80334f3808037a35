#include "balance/result/round_off.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace balance {

namespace {

constexpr std::array<std::pair<Samples Result::*, VectorX TermSizes::*>, 25> size_members = {{
    {&Result::joint_position, &TermSizes::position},
    {&Result::joint_velocity, &TermSizes::velocity},
    {&Result::joint_acceleration, &TermSizes::acceleration},
    {&Result::torque, &TermSizes::effort},
    {&Result::power, &TermSizes::power},
    {&Result::com_position, &TermSizes::com_position},
    {&Result::com_velocity, &TermSizes::com_velocity},
    {&Result::com_acceleration, &TermSizes::com_acceleration},
    {&Result::tool_position, &TermSizes::tool_position},
    {&Result::tool_orientation, &TermSizes::tool_angle},
    {&Result::shaking_force, &TermSizes::force},
    {&Result::shaking_moment, &TermSizes::moment},
    {&Result::ground_force, &TermSizes::force},
    {&Result::ground_moment, &TermSizes::moment},
    {&Result::joint_force, &TermSizes::joint_force},
    {&Result::joint_moment, &TermSizes::joint_moment},
    {&Result::kinetic_energy, &TermSizes::kinetic_energy},
    {&Result::potential_energy, &TermSizes::potential_energy},
    {&Result::desired_position, &TermSizes::position},
    {&Result::tracking_error, &TermSizes::position},
    {&Result::desired_tool_position, &TermSizes::tool_position},
    {&Result::tool_error, &TermSizes::tool_position},
    {&Result::tool_angle_error, &TermSizes::tool_angle},
    {&Result::sliding_variable, &TermSizes::sliding_variable},
    {&Result::torque_variation, &TermSizes::effort},
}};

}  // namespace

void set_round_off(Result& result, const TermSizes& terms, const TermSizes& grown) {
  result.term_sizes = terms;
  result.round_off = {};
  result.round_off.raise(grown, round_off_part);
}

VectorX TermSizes::*term_size_of(Samples Result::*array) {
  const auto found =
      std::find_if(size_members.begin(), size_members.end(), [&](const auto& size) { return size.first == array; });
  return found == size_members.end() ? nullptr : found->second;
}

double of_column(const Result& result, const TermSizes& sizes, Samples Result::*array, Eigen::Index column) {
  VectorX TermSizes::*const size = term_size_of(array);
  if (size == nullptr) return 0;
  const VectorX& known = sizes.*size;
  const Eigen::Index columns = (result.*array).cols();
  if (known.size() == 0 || columns == 0) return 0;
  if (known.size() == 1) return known[0];
  return known[std::min(known.size() - 1, column * known.size() / columns)];
}

double round_off_of(const Result& result, Samples Result::*array, Eigen::Index column) {
  return of_column(result, result.round_off, array, column);
}

Samples above_round_off(const Result& result, Samples Result::*array) {
  Samples values = result.*array;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const double round_off = round_off_of(result, array, c);
    if (round_off == 0) continue;
    for (Eigen::Index k = 0; k < values.rows(); ++k) values(k, c) = above(round_off, values(k, c));
  }
  return values;
}

}  // namespace balance
