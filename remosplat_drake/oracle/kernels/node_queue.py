"""A priority queue (binary heap) of tree nodes in two arrays (numba)."""

from remosplat_drake.base.kernels import helper


@helper
def push(keys, items, size, key, item):
    """Adds an item; returns the new size. The arrays must have room."""
    place = size
    while place > 0:
        parent = (place - 1) // 2
        if keys[parent] <= key:
            break
        keys[place], items[place] = keys[parent], items[parent]
        place = parent
    keys[place], items[place] = key, item
    return size + 1


@helper
def pop(keys, items, size):
    """Removes the item with the least key; returns key, item and new size."""
    top_key, top_item = keys[0], items[0]
    size -= 1
    key, item = keys[size], items[size]
    place = 0
    while 2 * place + 1 < size:
        child = 2 * place + 1
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[place], items[place] = keys[child], items[child]
        place = child
    keys[place], items[place] = key, item
    return top_key, top_item, size
