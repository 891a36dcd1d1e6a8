#include "engine/devices/serial_port.h"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <system_error>
#include <termios.h>
#include <unistd.h>
#include <utility>

namespace palpate {
namespace {

std::string system_text(int error) {
  return std::generic_category().message(error);
}

std::string group_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return "of the port";
  std::array<char, 1024> buffer;
  group entry{};
  group* found = nullptr;
  ::getgrgid_r(status.st_gid, &entry, buffer.data(), buffer.size(), &found);
  return found != nullptr ? std::string(found->gr_name) : std::to_string(status.st_gid);
}

Error port_error(const std::string& path, std::string problem, std::string hint) {
  return {ErrorCode::kFileUnreadable, path, "", std::move(problem), std::move(hint)};
}

Error busy_error(const std::string& path) {
  return port_error(path, "is used by another program; expected a free port",
                    "end that program; the command fuser " + path + " finds it");
}

Error not_a_terminal(const std::string& path) {
  return port_error(path, "is not a terminal; expected the serial port of a board",
                    "the ports of boards have names like /dev/ttyACM0");
}

Error open_error(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO: {
      Error missing = port_error(path, "is missing; expected the serial port of a board",
                                 "connect the board; the command ls /dev/ttyACM* lists ports");
      missing.code = ErrorCode::kFileNotFound;
      return missing;
    }
    case EACCES:
    case EPERM: {
      const std::string group = group_of(path);
      return port_error(
          path, "is not permitted; expected a user in the group " + group,
          "add the user with: sudo usermod -aG " + group + " USER; then log in again");
    }
    case EBUSY:
      return busy_error(path);
    case EISDIR:
      return not_a_terminal(path);
    default:
      return port_error(path, "cannot be opened: " + system_text(error), "");
  }
}

// Raw bytes. A read without bytes fails with EAGAIN; after a hang-up it returns 0.
bool set_raw(int descriptor) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return ::tcsetattr(descriptor, TCSANOW, &settings) == 0 && ::tcflush(descriptor, TCIOFLUSH) == 0;
}

// The result of read() or write(): no value if the line is dead.
std::optional<std::size_t> moved_bytes(ssize_t count, bool is_dead_without_bytes) {
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
  if (count == 0 && !is_dead_without_bytes) return 0;
  return std::nullopt;
}

}  // namespace

Result<SerialPort> SerialPort::open(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return open_error(path, errno);
  SerialPort port(descriptor);
  if (::isatty(descriptor) == 0) return not_a_terminal(path);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    // The exclusive mode is the other program's.
    port.descriptor_ = -1;
    ::close(descriptor);
    return busy_error(path);
  }
  if (::ioctl(descriptor, TIOCEXCL) != 0 || !set_raw(descriptor)) {
    return port_error(path, "cannot be set to raw mode: " + system_text(errno), "");
  }
  return Result<SerialPort>(std::move(port));
}

SerialPort::SerialPort(SerialPort&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

SerialPort& SerialPort::operator=(SerialPort&& other) noexcept {
  if (this != &other) {
    close();
    descriptor_ = std::exchange(other.descriptor_, -1);
  }
  return *this;
}

SerialPort::~SerialPort() {
  close();
}

void SerialPort::close() noexcept {
  if (descriptor_ < 0) return;
  // A terminal that somebody else keeps open would stay exclusive.
  ::ioctl(descriptor_, TIOCNXCL);
  ::close(descriptor_);
  descriptor_ = -1;
}

std::optional<std::size_t> SerialPort::read(std::span<std::uint8_t> bytes) noexcept {
  return moved_bytes(::read(descriptor_, bytes.data(), bytes.size()), true);
}

std::optional<std::size_t> SerialPort::write(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty()) return 0;
  return moved_bytes(::write(descriptor_, bytes.data(), bytes.size()), false);
}

}  // namespace palpate
