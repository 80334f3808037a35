#pragma once
/// Controllers that do not fit a mechanism and its trajectory.

#include <stdexcept>
#include <string>
#include <utility>

namespace balance::control {

/// The message is suitable for users.
class ControllerError : public std::invalid_argument {
 public:
  /// @param key of the controller in a spec: "kp", "model.without"
  ControllerError(std::string key, const std::string& message) : std::invalid_argument(message), key_(std::move(key)) {}

  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace balance::control
