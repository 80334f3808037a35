#pragma once
/// Quadratic forms of rates. Private to equations.

#include "balance/base/types.hpp"

#include <vector>

namespace balance {

/// Quadratic forms from their values at unit rates and sums of two: exact but for round-off.
/// @param at the forms' values at rates
template <class Values>
std::vector<MatrixX> polarise_quadratic_form(int size, const Values& at) {
  std::vector<VectorX> own;
  for (int r = 0; r < size; ++r) own.push_back(at(VectorX::Unit(size, r)));
  if (own.empty()) return {};
  std::vector<MatrixX> forms(static_cast<std::size_t>(own.front().size()), MatrixX(size, size));
  for (int r = 0; r < size; ++r)
    for (int s = 0; s <= r; ++s) {
      const VectorX value = r == s ? own[static_cast<std::size_t>(r)]
                                   : VectorX((at(VectorX::Unit(size, r) + VectorX::Unit(size, s)) -
                                              own[static_cast<std::size_t>(r)] - own[static_cast<std::size_t>(s)]) /
                                             2);
      for (std::size_t k = 0; k < forms.size(); ++k)
        forms[k](r, s) = forms[k](s, r) = value[static_cast<Eigen::Index>(k)];
    }
  return forms;
}

}  // namespace balance
