// Runs the ROS 2 node, which brings its own `main`.

#include <rclcpp/rclcpp.hpp>

#include "ticks.hpp"

void rclcpp::spin(std::shared_ptr<Node>)
{
  run([](double now, const Heard & heard) {
    fake::now = now;
    for (const auto & [signal, number] : heard) fake::subscriptions.at(signal)(number);
    fake::published.clear();
    fake::timer();
    Answer answer{fake::published, 0u, fake::said, fake::words};
    const auto status = answer.commands.extract("status");
    if (status) answer.status = static_cast<unsigned>(status.mapped());
    return answer;
  });
}
