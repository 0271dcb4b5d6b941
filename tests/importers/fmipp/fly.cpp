// Runs a plan with the FMI++ Library: `fly-fmipp PLAN.json`, whose FMUs are URIs of folders with unpacked FMUs.
// Uses co-simulation, or model exchange of one FMU if the plan's `interface` requires it.

#include "import/base/include/FMUCoSimulation_v2.h"
#include "import/base/include/FMUModelExchange_v2.h"

#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iomanip>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using boost::property_tree::ptree;
using Slave = fmi_2_0::FMUCoSimulation;
using Model = fmi_2_0::FMUModelExchange;

constexpr double EVENT_PRECISION = 1e-7; // s

struct Plan {
    double step;
    long count;
    long every;
    std::vector<std::string> record;
    std::vector<std::pair<std::string, std::string>> connections;
};

void check(fmippStatus status, const std::string &what) {
    if (status != fmippOK) {
        throw std::runtime_error(what + ": status " + std::to_string(status));
    }
}

// Splits `slave.variable` into its two parts.
std::pair<std::string, std::string> parts(const std::string &path) {
    const auto dot = path.find('.');
    return {path.substr(0, dot), path.substr(dot + 1)};
}

Plan plan_of(const ptree &tree) {
    Plan plan{tree.get<double>("step"), tree.get<long>("count"), tree.get<long>("every"), {}, {}};
    for (const auto &entry : tree.get_child("record")) {
        plan.record.push_back(entry.second.data());
    }
    for (const auto &entry : tree.get_child("connections")) {
        plan.connections.emplace_back(entry.second.front().second.data(), entry.second.back().second.data());
    }
    return plan;
}

// Writer of the record: a line of names, then a line per time.
class Record {
  public:
    Record(const std::string &path, const Plan &plan) : file_(path), names_(plan.record) {
        file_ << std::setprecision(std::numeric_limits<double>::max_digits10) << "time";
        for (const auto &name : names_) {
            file_ << ',' << name;
        }
        file_ << '\n';
    }

    template <class Get> void row(double time, Get get) {
        file_ << time;
        for (const auto &name : names_) {
            file_ << ',' << get(name);
        }
        file_ << '\n';
    }

    void close() {
        file_.close();
        if (!file_) {
            throw std::runtime_error("the record cannot be written");
        }
    }

  private:
    std::ofstream file_;
    std::vector<std::string> names_;
};

class Slaves {
  public:
    void add(const std::string &name, const std::string &uri, const std::string &identifier) {
        auto slave = std::make_unique<Slave>(uri, identifier, fmippTrue);
        check(slave->instantiate(name, 0.0, fmippFalse, fmippFalse), name);
        slaves_[name] = std::move(slave);
    }

    double get(const std::string &path) {
        const auto [name, variable] = parts(path);
        double value = 0.0;
        check(slaves_.at(name)->getValue(variable, value), path);
        return value;
    }

    void set(const std::string &path, double value) {
        const auto [name, variable] = parts(path);
        check(slaves_.at(name)->setValue(variable, value), path);
    }

    void initialize(const std::string &name) {
        check(slaves_.at(name)->initialize(0.0, fmippFalse, 0.0), name);
    }

    void step(double at, double size) {
        for (auto &[name, slave] : slaves_) {
            check(slave->doStep(at, size, fmippTrue), name);
        }
    }

    void exchange(const Plan &plan) {
        std::vector<double> values;
        for (const auto &connection : plan.connections) {
            values.push_back(get(connection.first));
        }
        for (std::size_t k = 0; k < values.size(); ++k) {
            set(plan.connections[k].second, values[k]);
        }
    }

  private:
    std::map<std::string, std::unique_ptr<Slave>> slaves_;
};

void co_simulate(const ptree &tree, const Plan &plan, Record &record) {
    Slaves slaves;
    for (const auto &[name, uri] : tree.get_child("fmus")) {
        slaves.add(name, uri.data(), tree.get_child("identifiers").get<std::string>(name));
    }
    for (const auto &[path, value] : tree.get_child("values")) {
        slaves.set(path, value.get_value<double>());
    }
    // FMI++ initialises each slave in one call: earlier slaves provide the start values of later ones.
    for (const auto &[name, uri] : tree.get_child("fmus")) {
        slaves.initialize(name);
        for (const auto &[source, sink] : plan.connections) {
            if (parts(source).first == name) {
                slaves.set(sink, slaves.get(source));
            }
        }
    }
    for (long k = 1; k <= plan.count; ++k) {
        slaves.step(static_cast<double>(k - 1) * plan.step, plan.step);
        slaves.exchange(plan);
        if (k % plan.every == 0) {
            record.row(static_cast<double>(k) * plan.step, [&](const auto &path) { return slaves.get(path); });
        }
    }
}

// Integrates by the Dormand-Prince method with step-size control, and stops at every event.
void exchange_model(const ptree &tree, const Plan &plan, Record &record) {
    const auto &[name, uri] = tree.get_child("fmus").front();
    Model model(uri.data(), tree.get_child("identifiers").get<std::string>(name), fmippTrue, fmippFalse,
                EVENT_PRECISION, IntegratorType::dp);
    check(model.instantiate(name), name);
    check(model.initialize(), name);
    for (long k = plan.every; k <= plan.count; k += plan.every) {
        const double end = static_cast<double>(k) * plan.step;
        for (long stops = 0; model.getTime() < end - EVENT_PRECISION; ++stops) {
            if (stops > plan.count) {
                throw std::runtime_error("the time does not go on");
            }
            model.integrate(end, plan.step / 4.0);
            check(model.getLastStatus(), "integrate");
        }
        record.row(end, [&](const auto &path) {
            double value = 0.0;
            check(model.getValue(parts(path).second, value), path);
            return value;
        });
    }
}

} // namespace

int main(int count, char **words) try {
    if (count != 2) {
        throw std::runtime_error("the file of a plan is missing");
    }
    ptree tree;
    boost::property_tree::read_json(words[1], tree);
    const Plan plan = plan_of(tree);
    Record record(tree.get<std::string>("out"), plan);
    if (tree.get<std::string>("interface", "co-simulation") == "model exchange") {
        exchange_model(tree, plan, record);
    } else {
        co_simulate(tree, plan, record);
    }
    record.close();
    return EXIT_SUCCESS;
} catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
}
