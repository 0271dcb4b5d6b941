// Runs the DUNE task.

#include <DUNE/DUNE.hpp>

#include <memory>

#include "ticks.hpp"

using namespace DUNE;

Tasks::Periodic* create(const std::string& name, Tasks::Context& context);

template <typename M>
static void send(const M & message) { fake::consumer<M>(&message); }

// What a task gets, but has to ignore.
static void send_others(bool is_engaged)
{
  IMC::EstimatedState of_another_vehicle{};
  of_another_vehicle.setSource(fake::system_id + 1);
  of_another_vehicle.theta = 1.0f;
  send(of_another_vehicle);
  IMC::WaterVelocity invalid{};
  invalid.x = 9.0;
  send(invalid);
  IMC::DesiredSpeed revolutions{};
  revolutions.value = 1000.0;
  revolutions.speed_units = IMC::SUNITS_RPM;
  send(revolutions);
  IMC::ControlLoops obsolete{};
  obsolete.enable = !is_engaged;
  obsolete.mask = IMC::CL_PITCH | IMC::CL_SPEED;
  send(obsolete);
}

static void send_all(const Heard & heard)
{
  const auto came = [&](const char * signal) { return heard.count(signal) != 0; };
  if (came("pitch") && came("pitch_rate")) {
    IMC::EstimatedState message{};
    message.theta = static_cast<float>(heard.at("pitch"));
    message.q = static_cast<float>(heard.at("pitch_rate"));
    send(message);
  }
  if (came("speed")) {
    IMC::WaterVelocity message{};
    message.validity = IMC::WaterVelocity::VAL_VEL_X;
    message.x = heard.at("speed");
    send(message);
  }
  if (came("pitch_reference")) {
    IMC::DesiredPitch message{};
    message.value = heard.at("pitch_reference");
    send(message);
  }
  if (came("speed_reference")) {
    IMC::DesiredSpeed message{};
    message.value = heard.at("speed_reference");
    send(message);
  }
  uint8_t id = 0;
  for (const char * signal : {"lower_applied", "upper_port_applied", "upper_starboard_applied"}) {
    IMC::SetThrusterActuation message{};
    message.id = id++;
    if (!came(signal)) continue;
    message.value = static_cast<float>(heard.at(signal));
    send(message);
  }
  if (came("engaged")) {
    IMC::ControlLoops message{};
    message.enable = heard.at("engaged") != 0.0;
    message.mask = IMC::CL_PITCH;
    if (message.enable) message.mask |= IMC::CL_SPEED;  // one that is disabled is enough
    message.scope_ref = 1;
    send(message);
    send_others(message.enable);
  }
}

int main()
{
  Tasks::Context context;
  const std::unique_ptr<Tasks::Periodic> task(create("autopilot", context));
  run([&](double now, const Heard & heard) {
    fake::now = now;
    send_all(heard);
    fake::dispatched.clear();
    task->task();
    static const char * const names[] = {"lower", "upper_port", "upper_starboard"};
    Answer answer{{}, static_cast<unsigned>(fake::state), fake::said, fake::words};
    for (const auto & [id, value] : fake::dispatched) answer.commands[names[id]] = value;
    return answer;
  });
}
