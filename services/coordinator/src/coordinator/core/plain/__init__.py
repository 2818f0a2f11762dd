"""The plain rules of the requirements, beside the better ones: the same states, chosen by `Rules` in `states.table`."""
