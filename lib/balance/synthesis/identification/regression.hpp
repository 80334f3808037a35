#pragma once
/// Records as linear equations in the unknown parameters: one channel for every measured effort, current or component of
/// the force on the frame.

#include "balance/motion/simulation/measurement_record.hpp"
#include "balance/synthesis/identification/motion_equation.hpp"
#include "balance/synthesis/identification/unknown_parameters.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::identification {

struct SignalOptions {
  double cutoff = 0;        ///< of the low-pass filter [Hz]; 0: from the bandwidth of the motion
  double rest_rate = 0.02;  ///< slower joints count as at rest, whose dry friction is unknown [rad/s or m/s], > 0
};

/// Consecutive rows of one channel: measured ≈ columns · x + known, all of them low-passed alike and decimated.
struct ChannelPiece {
  int record = 0;
  double step = 0;              ///< between rows [s]
  VectorX time;                 ///< per row [s]
  VectorX measured, known;      ///< [N m or N]; of a current [A] only `measured`
  VectorX slope;                ///< derivative of `measured` [per second]
  MatrixX columns;              ///< rows × unknowns
  VectorX rate;                 ///< of the channel's coordinate [rad/s or m/s]; zero for components of the frame
  std::vector<bool> moving;     ///< per row: the channel's coordinate is not at rest; true for components of the frame
  std::vector<bool> is_fitted;  ///< in addition, no other dry friction in the row is that of a coordinate at rest
};

struct Channel {
  std::string name;  ///< "A1", "frame fx"
  std::string unit;  ///< of the effort
  MeasuredSignal signal;
  int coordinate = -1;      ///< of the effort; −1: the frame
  bool is_current = false;  ///< measured = (columns · x + known) / gain
  std::vector<ChannelPiece> pieces;

  long count(std::vector<bool> ChannelPiece::*mask) const;
};

/// A state of the motion as it was measured.
struct MeasuredStates {
  int record = 0;
  VectorX time;        ///< rows
  MatrixX q, dq, ddq;  ///< rows × independent coordinates
};

struct Regression {
  double cutoff = 0;  ///< [Hz]
  std::vector<Channel> channels;
  std::vector<MeasuredStates> states;
  std::vector<std::string> notes;
};

/// A record that does not belong to the mechanism, or a motion that it cannot make; the message names the record.
struct RecordError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Coordinates that a record must have, in the order in which they become independent: those with positions, actuated
/// ones first.
std::vector<std::string> choose_measured_coordinates(const Mechanism& mechanism, const MeasurementRecord& record);

/// @param equations its independent coordinates are measured in every record
/// @param cutoff_of records whose bandwidth determines the cut-off, unless the options give one
/// @throws RecordError
Regression build_regression(MotionEquations& equations, const std::vector<UnknownParameter>& unknowns,
                            const std::vector<MeasurementRecord>& records, const SignalOptions& options);

/// The columns of one state: rows of the efforts in the order of the actuators if they are as many as the degrees of
/// freedom, else of the independent coordinates; then those of the frame.
struct RegressorRows {
  MatrixX columns;  ///< rows × unknowns
  VectorX known;
  MatrixX effort_map;   ///< rows of efforts × actuators: what the measured efforts are multiplied by
  bool is_held = true;  ///< whether the actuators hold the mechanism there, so that efforts can be solved for
  std::vector<std::vector<int>> dry;  ///< per row: coordinates with unknown dry friction that occur in it
};

/// @param known_values known_inertial_values() of the record
/// @param carried unknown payloads that are carried; columns of others are zero
/// @param rest_rate below it, dry friction grows with the rate, so that noise at rest does not count
RegressorRows make_regressor_rows(const Mechanism& mechanism, const MotionEquation& equation,
                                  const std::vector<UnknownParameter>& unknowns, const VectorX& known_values,
                                  const std::vector<std::string>& carried, double rest_rate);

/// Whether the actuators are as many as the degrees of freedom and can be solved for.
bool has_effort_rows(const Mechanism& mechanism, int freedoms);

}  // namespace balance::identification
