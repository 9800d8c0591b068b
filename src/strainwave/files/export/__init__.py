"""The plant and its controller elsewhere: C, functional mock-up units, joints of robot simulators."""
