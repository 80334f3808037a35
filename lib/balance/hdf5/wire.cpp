#include "balance/hdf5/wire.hpp"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>

namespace balance {

void Message::put(std::uint64_t number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  bytes_.append(bytes, sizeof number);
}

void Message::put(const std::string& text) {
  put(std::uint64_t{text.size()});
  bytes_ += text;
}

std::uint64_t Message::take_number() {
  std::uint64_t number = 0;
  if (bytes_.size() - at_ < sizeof number) throw WireBroken("a message is too short");
  std::memcpy(&number, bytes_.data() + at_, sizeof number);
  at_ += sizeof number;
  return number;
}

std::string Message::take_text() {
  const std::uint64_t length = take_number();
  if (bytes_.size() - at_ < length) throw WireBroken("a message is too short");
  at_ += length;
  return bytes_.substr(at_ - length, length);
}

void Wire::send(const Message& message) const {
  const std::uint64_t length = message.bytes().size();
  send_bytes(&length, sizeof length);
  send_bytes(message.bytes().data(), message.bytes().size());
}

Message Wire::receive(std::size_t most) const {
  std::uint64_t length = 0;
  receive_bytes(&length, sizeof length);
  if (length > most) throw WireBroken("a message is too long");
  std::string bytes(length, '\0');
  receive_bytes(bytes.data(), bytes.size());
  return Message(std::move(bytes));
}

void Wire::send(std::span<const double> values) const { send_bytes(values.data(), values.size_bytes()); }

void Wire::receive(std::span<double> values) const { receive_bytes(values.data(), values.size_bytes()); }

void Wire::send_bytes(const void* from, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::send(socket_, static_cast<const char*>(from) + done, count - done, MSG_NOSIGNAL);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw WireBroken("nobody listens");
    done += static_cast<std::size_t>(now);
  }
}

void Wire::receive_bytes(void* to, std::size_t count) const {
  for (std::size_t done = 0; done < count;) {
    const ssize_t now = ::recv(socket_, static_cast<char*>(to) + done, count - done, 0);
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) throw WireBroken("nobody speaks");
    done += static_cast<std::size_t>(now);
  }
}

}  // namespace balance
