// Runs a shell of docs/embedding by lines of standard input, one for each call of its timer: the time (s), and what
// comes then of each signal below, or `-` if nothing comes. Answers with a line of how many actuators were commanded,
// each command, the status, how many times it said something, and what it said last. A line before has the safe
// commands.
#pragma once

#include <cstdio>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <string>

#include "squid.h"

using Heard = std::map<std::string, double>;

struct Answer {
  std::map<std::string, double> commands;
  unsigned status;
  int said;
  std::string words;
};

// `tick` takes the time and what is heard, and returns an Answer.
template <typename Tick>
void run(Tick tick)
{
  static const char * const signals[] = {
    "pitch", "speed", "pitch_rate", "pitch_reference", "speed_reference",
    "lower_applied", "upper_port_applied", "upper_starboard_applied", "engaged"};
  squid_commands safe;
  squid_safe(&safe);
  std::printf("%.17g %.17g %.17g\n", safe.lower, safe.upper_port, safe.upper_starboard);
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    const double now = std::stod(word);
    Heard heard;
    for (const char * signal : signals)
      if (words >> word && word != "-") heard[signal] = std::stod(word);
    const Answer answer = tick(now, heard);
    std::printf("%zu ", answer.commands.size());
    for (const char * name : {"lower", "upper_port", "upper_starboard"}) {
      const auto command = answer.commands.find(name);
      const bool is_there = command != answer.commands.end();
      std::printf("%.17g ", is_there ? command->second : std::numeric_limits<double>::quiet_NaN());
    }
    std::printf("%u %d %s\n", answer.status, answer.said, answer.words.c_str());
  }
}
