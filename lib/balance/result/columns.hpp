#pragma once
/// The shape of a Result. For what makes one.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

namespace balance {

/// What the columns are called, and in what.
void name_columns(const Mechanism& mechanism, Result& result);

/// Which arrays a formulation fills.
enum class Contents {
  everything,
  without_reactions,  ///< no wrenches of single joints and no measure of mobility
};

/// Room for as many rows in every array.
void size_arrays(const Mechanism& mechanism, long rows, Contents contents, Result& result);

}  // namespace balance
