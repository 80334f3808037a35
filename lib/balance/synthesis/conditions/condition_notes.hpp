#pragma once
/// Notes of conditions that those who know more of the spec replace.

namespace balance::conditions {

inline constexpr const char* no_gravity_note = "there is no gravity in this spec: weight imposes no condition";

}  // namespace balance::conditions
