"""Where is the avatar now? Sender and receivers both ask this; an update goes out when the answer is more than 0.3 m off."""


def predict(updates, t):
    """The place (x, y) in metres at time t in seconds.

    `updates` are the latest ones, at most 8, oldest first. Each has t, x, y, velocity vx, vy in m/s and acceleration ax, ay in
    m/s^2, all of them as they were at its t. This predictor believes that nothing ever moves.
    """
    last = updates[-1]
    return last["x"], last["y"]
