#pragma once
/// Vibration modes, the response of driven machines and sweeps as text, JSON and HDF5.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/motion/vibration/speed_sweep.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

/// What is swept.
struct SweptNumber {
  std::string name;  ///< a parameter of the spec, or the joint that turns
  std::string unit;  ///< of the values, which are in the spec's units; empty: of a parameter
};

struct VibrationReportData {
  Mechanism mechanism;
  vibration::VibrationModes modes;
  std::optional<vibration::ForcedResponse> response;  ///< where driven joints make whole turns
  std::optional<vibration::SpeedSweep> sweep;
  SweptNumber swept;
  std::vector<std::string> warnings;  ///< of the spec
};

// Modes alone, as `balance check` has them.

/// One object with the reference, the modes and their stability.
Json vibration_json(const vibration::VibrationModes& modes, const Mechanism& mechanism);
/// "1  2.64 Hz, damping ratio 0.14: F.x 0.3 m", one line per mode after a line that says what they are.
/// @param label of the first line
std::string vibration_text(const vibration::VibrationModes& modes, const Mechanism& mechanism, const std::string& label,
                           std::size_t label_width, const files::TextOptions& options);

// All of `balance modes`.

Json vibration_report_json(const VibrationReportData& view);
std::string vibration_report_text(const VibrationReportData& view, const files::TextOptions& options);

/// Of the page: modes with their text, the response, and the sweep as arrays over its values.
Json vibration_page_json(const VibrationReportData& view);
/// "mode 2: 2.64 Hz, damping ratio 0.14"
std::string mode_title(const vibration::VibrationModes& modes, std::size_t k);

/// Writes the complete file or none. @throws SystemError, Cancelled as write_result_hdf5
void write_vibration_report(const std::string& path, const VibrationReportData& view,
                            const files::Provenance& description, const files::WriteOptions& options);

}  // namespace balance::reports
