#pragma once
/// Samples as rows of a RunResult, by the table of quantities.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <vector>

namespace balance {

/// What a kind of run knows besides what every run knows.
struct RecordedContents {
  bool reactions = true;  ///< Availability::reactions
  bool control = false;   ///< Availability::control
  bool tracking = false;  ///< Availability::tracking and tool_tracking
};

/// What the columns are called, and in what.
void name_columns(const Mechanism& mechanism, RunResult& result);

/// Room for as many rows in the arrays of every quantity that the run has; the columns must have names.
void resize_arrays(const Mechanism& mechanism, long rows, const RecordedContents& contents, RunResult& result);

/// Forgets all samples but the first `rows`.
void truncate_rows(long rows, RunResult& result);

/// Writes samples, in the order of time, into the rows of one RunResult or of several of the same shape.
class ResultRecorder {
 public:
  /// @param shape a result with its names and arrays
  explicit ResultRecorder(const RunResult& shape);

  void write(const Sample& sample, long row, RunResult& result);

 private:
  /// How a quantity's columns lie in a Sample: `blocks` groups of `width` numbers, `stride` apart, the first after `skip` numbers.
  struct ColumnMapping {
    const QuantityDefinition* kind;
    bool quaternion;
    long blocks, width, stride, skip;
  };

  std::vector<ColumnMapping> entries_;
  Eigen::Vector4d quaternion_ = Eigen::Vector4d::Zero();  ///< the last one, whose sign goes on
};

}  // namespace balance
