// One writer, many readers: every read value was published, is complete, and is never older than
// the reader's previous value.

#include "engine/devices/snapshot_ring.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Every word follows from the sequence number, which reveals a mixture of two values.
template <std::size_t kWords>
struct PatternOf {
  std::uint64_t sequence = 0;
  std::array<std::uint64_t, kWords> words{};

  static std::uint64_t word(std::uint64_t sequence, std::size_t i) {
    std::uint64_t x = sequence * 0x9e3779b97f4a7c15u + i * 0xbf58476d1ce4e5b9u;
    x ^= x >> 31;
    return x * 0x94d049bb133111ebu;
  }
  static PatternOf of(std::uint64_t sequence) {
    PatternOf p;
    p.sequence = sequence;
    for (std::size_t i = 0; i < p.words.size(); ++i) p.words[i] = word(sequence, i);
    return p;
  }
  bool is_whole() const {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] != word(sequence, i)) return false;
    }
    return true;
  }
};

using Pattern = PatternOf<21>;

struct ReaderReport {
  std::uint64_t reads = 0;
  std::uint64_t distinct = 0;
  std::uint64_t torn = 0;
  std::uint64_t steps_back = 0;
  std::uint64_t touched_on_failure = 0;
};

template <typename Value, std::size_t kSlots>
void read_until(const SnapshotRing<Value, kSlots>& ring, std::uint64_t last_sequence,
                ReaderReport& report) {
  std::uint64_t newest = 0;
  while (newest < last_sequence) {
    Value value = Value::of(newest);
    if (!ring.read(value)) {
      if (value.sequence != newest || !value.is_whole()) ++report.touched_on_failure;
      std::this_thread::yield();
      continue;
    }
    ++report.reads;
    if (!value.is_whole()) ++report.torn;
    if (value.sequence < newest) ++report.steps_back;
    if (value.sequence > newest) ++report.distinct;
    newest = std::max(newest, value.sequence);
  }
}

template <typename Value, std::size_t kSlots>
void stress(std::uint64_t values) {
  constexpr int kReaders = 3;
  SnapshotRing<Value, kSlots> ring;
  std::vector<ReaderReport> reports(kReaders);
  std::vector<std::thread> readers;
  for (ReaderReport& report : reports) {
    readers.emplace_back([&ring, values, &report] { read_until(ring, values, report); });
  }
  for (std::uint64_t s = 1; s <= values; ++s) {
    ring.publish(Value::of(s));
    if (s % 1024 == 0) std::this_thread::yield();  // lets readers run on any number of cores
  }
  for (std::thread& reader : readers) reader.join();
  for (const ReaderReport& report : reports) {
    EXPECT_GT(report.reads, 0u);
    EXPECT_GT(report.distinct, 0u);
    EXPECT_EQ(report.torn, 0u);
    EXPECT_EQ(report.steps_back, 0u);
    EXPECT_EQ(report.touched_on_failure, 0u);
  }
}

TEST(SnapshotRing, ReadFailsBeforeTheFirstValue) {
  const SnapshotRing<Pattern> ring;
  Pattern value = Pattern::of(42);
  EXPECT_FALSE(ring.read(value));
  EXPECT_EQ(value.sequence, 42u);
  EXPECT_TRUE(value.is_whole());
}

TEST(SnapshotRing, ReadsTheNewestValueAfterAnyNumberOfRounds) {
  SnapshotRing<Pattern> ring;
  for (std::uint64_t s = 1; s <= 1000; ++s) {
    ring.publish(Pattern::of(s));
    for (int again = 0; again < 2; ++again) {
      Pattern value;
      ASSERT_TRUE(ring.read(value));
      ASSERT_EQ(value.sequence, s);
      ASSERT_TRUE(value.is_whole());
    }
  }
}

TEST(SnapshotRing, StoresValuesOfAnySize) {
  struct Odd {
    std::array<std::uint8_t, 13> bytes;
  };
  SnapshotRing<Odd, 3> ring;
  for (int s = 1; s <= 20; ++s) {
    Odd odd{};
    for (std::size_t i = 0; i < odd.bytes.size(); ++i) {
      odd.bytes[i] = static_cast<std::uint8_t>(s * 31 + static_cast<int>(i));
    }
    ring.publish(odd);
    Odd back{};
    ASSERT_TRUE(ring.read(back));
    EXPECT_EQ(back.bytes, odd.bytes);
  }
}

TEST(SnapshotRing, NeverReturnsAMixtureOrAnOlderValue) {
  stress<Pattern, 64>(100'000);
}

// With two slots the writer overtakes readers constantly; they must detect this.
TEST(SnapshotRing, DetectsAWriterThatOvertakesAReader) {
  stress<Pattern, 2>(100'000);
}

// Copying this value takes as long as the writer needs to reuse the slot.
TEST(SnapshotRing, DetectsAWriterInTheMiddleOfTheSlot) {
  stress<PatternOf<500>, 2>(20'000);
}

}  // namespace
}  // namespace palpate
