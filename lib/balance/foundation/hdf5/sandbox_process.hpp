#pragma once
/// Messages between two processes that do not trust each other.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

namespace balance::hdf5 {

// Runs dangerous work in a copy of this process.

/// Resources that the copy may use; 0: no limit.
struct SandboxLimits {
  std::uintmax_t cpu_seconds = 0;   ///< of CPU time
  std::uintmax_t memory_bytes = 0;  ///< in addition to what this process uses now
};

enum class SandboxAccess {
  socket_only,  ///< inherits no other descriptors, prints nothing, writes no file
  files,        ///< as this process
};

/// Exit codes of a child whose work threw std::bad_alloc, or anything else.
inline constexpr int exit_out_of_memory = 86, exit_without_result = 87;

/// A child process connected by a socket. It may crash, hang or use too much memory, which ends the connection. It has a
/// process group of its own: signals from the keyboard reach only the parent, which decides. It ends with this process,
/// even if that is killed.
class SandboxProcess {
 public:
  /// @param work runs in the child with its end of the connection. The child is a copy of this thread only: the work
  ///   must not need a lock that another thread may hold, except Hdf5Lock
  /// @throws std::system_error if the system cannot provide a process or socket
  SandboxProcess(const std::function<void(int)>& work, const SandboxLimits& limits, SandboxAccess access);
  /// Kills the child and everything that it started.
  ~SandboxProcess();
  SandboxProcess(const SandboxProcess&) = delete;
  SandboxProcess& operator=(const SandboxProcess&) = delete;

  /// This process's end: a connected socket.
  int socket() const { return socket_; }
  int process_id() const { return child_; }

  /// How the child ended, as waitpid reports it; empty: it has not ended.
  std::optional<int> find_exit_status();
  /// Ends the connection and waits until the child ends by itself.
  void finish();

 private:
  void wait(int options);

  int socket_ = -1;
  int child_ = -1;
  std::optional<int> exit_status_;
};

/// From here on this process cannot open files; those already open stay open.
void forbid_opening_files();

/// The other end is gone or sends invalid data.
struct ChannelError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A sequence of numbers and texts, read in the order in which they were written.
class Message {
 public:
  Message() = default;
  explicit Message(std::string bytes) : bytes_(std::move(bytes)) {}

  void write(std::uint64_t number);
  void write(const std::string& text);
  /// @throws ChannelError at the end of the message
  std::uint64_t read_number();
  std::string read_text();

  bool is_at_end() const { return position_ == bytes_.size(); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

/// One end of a connected socket; does not own it.
class MessageChannel {
 public:
  explicit MessageChannel(int socket) : socket_(socket) {}

  void send(const Message& message) const;
  /// @param max_bytes maximum number of bytes. @throws ChannelError if the message is longer or does not arrive
  Message receive(std::size_t max_bytes) const;

  void send(std::span<const double> values) const;
  void receive(std::span<double> values) const;

 private:
  void send_bytes(const void* from, std::size_t count) const;
  void receive_bytes(void* to, std::size_t count) const;

  int socket_;
};

}  // namespace balance::hdf5
