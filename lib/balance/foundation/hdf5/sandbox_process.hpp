#pragma once
/// Messages between two processes that do not trust each other.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>

namespace balance {

// Doing something dangerous in a copy of this process.

/// What the copy may use.
struct SandboxLimits {
  std::uintmax_t cpu_seconds = 1;   ///< of the processor
  std::uintmax_t memory_bytes = 0;  ///< of memory, besides what this process has now
};

/// A child process with a line to it. It prints nothing, writes no file, has none of the descriptors of this process, and may crash, hang
/// or use too much memory: the line then ends. It is gone, at the latest, when this is.
class SandboxProcess {
 public:
  /// @param work runs in the child, with the child's end of the line; it must need no lock that another thread may hold
  /// @throws std::system_error if the system has no process or line left
  SandboxProcess(const std::function<void(int)>& work, const SandboxLimits& limits);
  ~SandboxProcess();
  SandboxProcess(const SandboxProcess&) = delete;
  SandboxProcess& operator=(const SandboxProcess&) = delete;

  /// This process's end: a connected socket.
  int socket() const { return line_; }

 private:
  int line_ = -1;
  int child_ = -1;
};

/// From here on this process opens no file any more; those that are open stay.
void forbid_opening_files();

/// The other end is gone, or says what makes no sense.
struct ChannelError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Numbers and texts one behind the other; taken out in the order in which they were put in.
class Message {
 public:
  Message() = default;
  explicit Message(std::string bytes) : bytes_(std::move(bytes)) {}

  void write(std::uint64_t number);
  void write(const std::string& text);
  /// @throws ChannelError if there is no more
  std::uint64_t read_number();
  std::string read_text();

  bool is_at_end() const { return at_ == bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// One end of a connected socket, which somebody else closes.
class MessageChannel {
 public:
  explicit MessageChannel(int socket) : socket_(socket) {}

  void send(const Message& message) const;
  /// @param most bytes. @throws ChannelError if the message is longer or does not come
  Message receive(std::size_t most) const;

  void send(std::span<const double> values) const;
  void receive(std::span<double> values) const;

 private:
  void send_bytes(const void* from, std::size_t count) const;
  void receive_bytes(void* to, std::size_t count) const;

  int socket_;
};

}  // namespace balance
