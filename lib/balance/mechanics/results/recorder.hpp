#pragma once
/// Writes samples into rows of a RunResult, according to the table of quantities.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <cstddef>
#include <vector>

namespace balance::results {

/// Contents of a kind of run besides those that every run has.
struct RecordedContents {
  bool reactions = true;  ///< Availability::reactions
  bool control = false;   ///< Availability::control
  bool tracking = false;  ///< Availability::tracking and tool_tracking
};

/// Sets the names and units of the columns.
void name_columns(const Mechanism& mechanism, RunResult& result);

/// Allocates the rows of every quantity that the run has. @pre the columns have names
void resize_arrays(const Mechanism& mechanism, long rows, const RecordedContents& contents, RunResult& result);

/// Drops all samples but the first `rows`.
void truncate_rows(long rows, RunResult& result);

/// Drops all actuators but the first `count`.
void truncate_actuators(std::size_t count, RunResult& result);

/// Writes samples, in order of time, into the rows of one RunResult or of several with the same shape.
class ResultRecorder {
 public:
  /// @param shape a result with its names and arrays
  explicit ResultRecorder(const RunResult& shape);

  void write(const Sample& sample, long row, RunResult& result);

 private:
  /// Layout of a quantity's columns in a Sample: `blocks` groups of `width` numbers with spacing `stride`, starting
  /// after `skip` numbers.
  struct ColumnMapping {
    const QuantityDefinition* kind;
    bool quaternion;
    long blocks, width, stride, skip;
  };

  std::vector<ColumnMapping> entries_;
  Eigen::Vector4d quaternion_ = Eigen::Vector4d::Zero();  ///< the previous one, for sign continuity
};

}  // namespace balance::results
