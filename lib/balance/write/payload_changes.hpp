#pragma once
/// Payloads taken up and set down in a run, as text, JSON and HDF5. Private to the writers and the page.

#include "balance/hdf5/file.hpp"
#include "balance/result/result.hpp"
#include "balance/write/json_parts.hpp"

#include <string>

namespace balance {

/// "cargo taken up at 0.2 s: R1 from 3.1 to 7.4 N m, R2 from …", a line each; empty if there is none.
std::string format_payload_events(const RunResult& result);

/// [{payload, change, time, speed, turning, torque: [{actuator, unit, before, after}]}].
Json payload_events_json(const RunResult& result);

/// The group `payload_events`, if there is any.
void write_payload_events(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result);

}  // namespace balance
