#pragma once
/// How long a motion may last and how often it may be sampled, wherever that is stated: beyond, a misprint is likelier than a wish.

#include "balance/motion/trajectory.hpp"

namespace balance {

inline constexpr double min_duration = 1e-9, max_duration = 1e9;  ///< [s]
inline constexpr long min_samples = 2, max_samples = 100'000'000;

/// "a duration from 1e-09 s to 1e+09 s"
std::string format_duration_range();

inline bool is_valid_duration(double duration) { return duration >= min_duration && duration <= max_duration; }
inline bool is_valid_sample_count(long samples) { return samples >= min_samples && samples <= max_samples; }

/// @throws std::invalid_argument if the trajectory is longer, shorter, or sampled more or less often than any may be
void check_timing(const Trajectory& trajectory);

/// @param duration [s] @throws std::invalid_argument if it is none, or something else says how long the trajectory takes
void change_duration(Trajectory& trajectory, double duration);

/// @throws std::invalid_argument if there cannot be so many
void change_samples(Trajectory& trajectory, long samples);

}  // namespace balance
