#pragma once
/// Numbers of a mechanism to differentiate by.

#include "balance/mechanics/derivatives/dual_evaluator.hpp"

#include <functional>
#include <random>
#include <string>
#include <vector>

namespace gradients {

struct Number {
  std::string name;
  double scale;  ///< its size, or the mechanism's length where it may be zero
  std::function<double&(balance::Mechanism&)> in;
  std::function<balance::derivatives::DualNumber&(balance::MechanismOf<balance::derivatives::DualNumber>&)> in_duals;
};

/// At most so many of masses, places of masses and joints, inertias, attachments, discs' and couplings' ratios, springs, friction,
/// loads, gravity: different ones.
std::vector<Number> some_numbers(const balance::Mechanism& mechanism, std::size_t most, std::mt19937& random);

}  // namespace gradients
