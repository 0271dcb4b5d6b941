// A ROS 2 node around the autopilot that `squid export vehicles/squid` writes. Copy it, and change the parts marked
// "Change".
//
// Build it with squid.c, which is C: add both to `add_executable` of a package that depends on rclcpp and std_msgs.

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/u_int32.hpp>

#include "squid.h"

using std_msgs::msg::Bool;
using std_msgs::msg::Float64;
using std_msgs::msg::UInt32;

class Autopilot : public rclcpp::Node {
public:
  Autopilot() : Node("autopilot")
  {
    squid_init(&state_, &out_);
    // Change: the topics of your sensors and of your guidance, in the units of squid.h.
    measure("pitch", in_.pitch, heard_pitch_);
    measure("speed", in_.speed, heard_speed_);
    measure("pitch_rate", in_.pitch_rate, heard_pitch_rate_);
    take<Float64>("pitch_reference", in_.pitch_reference);
    take<Float64>("speed_reference", in_.speed_reference);
    // Change: the commands that the thrusters actually receive, also from a pilot.
    take<Float64>("lower_applied", applied_.lower);
    take<Float64>("upper_port_applied", applied_.upper_port);
    take<Float64>("upper_starboard_applied", applied_.upper_starboard);
    take<Bool>("engaged", engaged_);
    // Change: the topics of your thrusters.
    lower_ = create_publisher<Float64>("lower", 1);
    upper_port_ = create_publisher<Float64>("upper_port", 1);
    upper_starboard_ = create_publisher<Float64>("upper_starboard", 1);
    status_ = create_publisher<UInt32>("status", 1);
    timer_ = create_wall_timer(std::chrono::duration<double>(SQUID_SAMPLE_TIME), [this] { on_timer(); });
  }

private:
  // Initial value of every input: not a number, so that an input without a message is refused.
  static constexpr squid_real none = std::numeric_limits<squid_real>::quiet_NaN();
  // Missed ticks are caught up; after more than this number the autopilot is reset.
  static constexpr long most_made_up = 5;

  template <typename Message, typename Number>
  void take(const std::string & topic, Number & number)
  {
    const auto callback = [&number](const Message & message) {
      if (std::isfinite(message.data)) number = message.data;  // otherwise the last one is kept
    };
    subscriptions_.push_back(create_subscription<Message>(topic, 1, callback));
  }

  void measure(const std::string & topic, squid_real & number, double & heard)
  {
    // Change: if your messages have a time stamp, use it.
    const auto callback = [this, &number, &heard](const Float64 & message) {
      number = message.data;
      heard = clock_.now().seconds();
    };
    subscriptions_.push_back(create_subscription<Float64>(topic, rclcpp::SensorDataQoS(), callback));
  }

  void on_timer()
  {
    const double now = clock_.now().seconds();
    const long due = std::lround((now - last_) / SQUID_SAMPLE_TIME);
    const bool is_new = !is_running_ || due > most_made_up;
    last_ = is_new ? now : last_ + due * SQUID_SAMPLE_TIME;
    in_.pitch_age = now - heard_pitch_;
    in_.speed_age = now - heard_speed_;
    in_.pitch_rate_age = now - heard_pitch_rate_;

    int code = SQUID_OK;
    if (is_new) {  // if refused, it continues from its present state
      code = squid_reset(&state_, &in_, &out_);
      is_running_ = code == SQUID_OK;
      has_started_ |= is_running_;
    }
    if (!has_started_) return report(code);  // an input has had no message yet

    const bool follows = is_new || !engaged_ || !was_engaged_;
    const bool has_followed = follows && squid_follow(&state_, &in_, &applied_) == SQUID_OK;
    for (long i = is_new ? 1 : due; i > 0; i--) code = squid_step(&state_, &in_, &out_);
    // After a refused input the last commands hold. Without commands to follow, it starts with a reset.
    is_running_ = (code == SQUID_OK || (code == SQUID_BAD_INPUT && is_running_)) && (engaged_ || has_followed);
    was_engaged_ = engaged_;

    if (engaged_) {
      applied_ = {out_.lower, out_.upper_port, out_.upper_starboard};
      send<Float64>(lower_, out_.lower);
      send<Float64>(upper_port_, out_.upper_port);
      send<Float64>(upper_starboard_, out_.upper_starboard);
    }
    send<UInt32>(status_, out_.status);
    report(code);
  }

  // Reports a changed status, except for commands at their limits, which come and go.
  void report(int code)
  {
    const unsigned saturated = SQUID_SATURATED | SQUID_SATURATED_LOWER | SQUID_SATURATED_UPPER_PORT |
                               SQUID_SATURATED_UPPER_STARBOARD;
    const unsigned status = out_.status & ~saturated;
    if (code == said_code_ && status == said_status_) return;
    said_code_ = code;
    said_status_ = status;
    const char * words = "no fault";
    if (!has_started_) words = "an input has not come yet: nothing is commanded";
    else if (code == SQUID_BAD_INPUT) words = "an input is no number: the last commands hold";
    else if (code != SQUID_OK) words = "nothing could be computed: it starts anew";
    else if ((status & SQUID_FAILED) != 0u) words = "the pitch rate is lost: the commands go to safe";
    else if ((status & SQUID_LOST_PITCH) != 0u) words = "the pitch is lost: it is reckoned from its rate";
    else if ((status & SQUID_LOST_SPEED) != 0u) words = "the speed is lost";
    else if ((status & SQUID_OUT_OF_RANGE) != 0u) words = "the speed is out of range";
    else if ((status & SQUID_REFERENCE_LIMITED) != 0u) words = "a reference is not used as it is asked";
    RCLCPP_WARN(get_logger(), "status 0x%x: %s", status, words);
  }

  template <typename Message, typename Number>
  static void send(const std::shared_ptr<rclcpp::Publisher<Message>> & to, Number number)
  {
    Message message;
    message.data = number;
    to->publish(message);
  }

  rclcpp::Clock clock_{RCL_STEADY_TIME};  // the clock of the timer
  double heard_pitch_ = 0.0, heard_speed_ = 0.0, heard_pitch_rate_ = 0.0;  // s, when the last message came
  double last_ = 0.0;  // s, when the last tick was due
  bool engaged_ = false, was_engaged_ = false;
  bool has_started_ = false, is_running_ = false;
  int said_code_ = SQUID_OK;
  unsigned said_status_ = 0u;
  squid_state state_;
  squid_inputs in_{none, none, none, none, none, 0.0, 0.0, 0.0};
  squid_outputs out_;
  squid_commands applied_{none, none, none};
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  rclcpp::Publisher<Float64>::SharedPtr lower_, upper_port_, upper_starboard_;
  rclcpp::Publisher<UInt32>::SharedPtr status_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char ** argv)
{
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Autopilot>());
  rclcpp::shutdown();
  return 0;
}
